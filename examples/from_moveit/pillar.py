"""Round a pillar: through waypoints placed by hand, as one had to, and without any."""

import copy
import sys

from trajopt.ros import commander as moveit_commander
from trajopt.ros.commander import geometry_msgs


def main() -> int:
    """Go past the pillar with waypoints, and back without."""
    group = moveit_commander.MoveGroupCommander("panda_arm")
    scene = moveit_commander.PlanningSceneInterface()
    group.set_max_velocity_scaling_factor(0.5)
    group.set_max_acceleration_scaling_factor(0.5)

    pillar = geometry_msgs.msg.PoseStamped()
    pillar.header.frame_id = "panda_link0"
    pillar.pose.orientation.w = 1.0
    pillar.pose.position.x, pillar.pose.position.z = 0.5, 0.4
    scene.add_cylinder("pillar", pillar, height=0.8, radius=0.06)

    left = geometry_msgs.msg.Pose()
    left.orientation.x = 1.0
    left.position.x, left.position.y, left.position.z = 0.45, -0.4, 0.3
    right = copy.deepcopy(left)
    right.position.y = 0.4
    group.set_pose_target(left)
    if not group.go(wait=True):
        return 1

    durations: list[float] = []
    for y in (-0.2, 0.0, 0.2):  # By hand: drawn back, past the pillar, and on.
        waypoint = copy.deepcopy(left)
        waypoint.position.x, waypoint.position.y = 0.3, y
        durations.append(moved(group, waypoint))
    durations.append(moved(group, right))
    print(f"with waypoints: {sum(durations):.2f} s, stopping at each")

    alone = moved(group, left)
    print(f"without: {alone:.2f} s")
    return 0 if min(*durations, alone) > 0.0 and alone < sum(durations) else 1


def moved(group: moveit_commander.MoveGroupCommander, goal: geometry_msgs.msg.Pose) -> float:
    """Go to a pose and return how long it takes; 0 if it cannot be."""
    group.set_pose_target(goal)
    success, trajectory, _, error_code = group.plan()
    print(group.get_last_result().certificate if success else error_code.message)
    if not success or not group.execute(trajectory, wait=True):
        return 0.0
    return trajectory.joint_trajectory.points[-1].time_from_start.to_sec()


if __name__ == "__main__":
    with moveit_commander.World("panda"):
        sys.exit(main())
