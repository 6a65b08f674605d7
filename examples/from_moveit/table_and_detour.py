"""Objects in the planning scene: the arm goes round a box that is put into its way."""

import sys

from trajopt.ros import commander as moveit_commander
from trajopt.ros.commander import geometry_msgs


def box_at(x: float, y: float, z: float) -> geometry_msgs.msg.PoseStamped:
    """Return a pose in the frame of the base."""
    pose = geometry_msgs.msg.PoseStamped()
    pose.header.frame_id = "panda_link0"
    pose.pose.orientation.w = 1.0
    pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = x, y, z
    return pose


def main() -> int:
    """Go from side to side, before and after a wall is put between."""
    group = moveit_commander.MoveGroupCommander("panda_arm")
    scene = moveit_commander.PlanningSceneInterface(synchronous=True)
    scene.add_box("table", box_at(0.5, 0.0, -0.03), size=(0.9, 1.6, 0.04))
    group.set_max_velocity_scaling_factor(0.5)
    group.set_max_acceleration_scaling_factor(0.5)

    left = geometry_msgs.msg.Pose()
    left.orientation.x = 1.0
    left.position.x, left.position.y, left.position.z = 0.45, -0.35, 0.35
    right = geometry_msgs.msg.Pose(geometry_msgs.msg.Point(0.45, 0.35, 0.35), left.orientation)

    group.set_pose_target(left)
    reached = [group.go(wait=True)]
    group.set_pose_target(right)
    _, straight, _, _ = group.plan()

    scene.add_box("wall", box_at(0.45, 0.0, 0.3), size=(0.5, 0.06, 0.6))
    print("the scene:", scene.get_known_object_names())
    success, detour, _, error_code = group.plan()  # It sees the box that was just added.
    if not success:
        print(error_code.message)
        return 1
    print(group.get_last_result().certificate)
    durations = [each.joint_trajectory.points[-1].time_from_start.to_sec() for each in (straight, detour)]
    print(f"without the wall {durations[0]:.2f} s, around it {durations[1]:.2f} s")
    reached.append(group.execute(detour, wait=True))
    print(group.get_last_outcome().error_code.message)
    return 0 if all(reached) and durations[1] > durations[0] else 1


if __name__ == "__main__":
    with moveit_commander.World("panda"):
        sys.exit(main())
