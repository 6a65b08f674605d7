"""The first script of MoveIt's Python tutorial: a joint goal, then a pose goal."""

import math
import sys

from trajopt.ros import commander as moveit_commander
from trajopt.ros.commander import geometry_msgs, rospy


def main() -> int:
    """Go to joint values, then to a pose."""
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("first_pose_goal", anonymous=True)
    robot = moveit_commander.RobotCommander()
    group = moveit_commander.MoveGroupCommander("panda_arm")
    print("planning frame", group.get_planning_frame(), "- end effector", group.get_end_effector_link())
    print("groups", robot.get_group_names())

    joint_goal = group.get_current_joint_values()
    joint_goal[0] = 0.0
    joint_goal[1] = -math.pi / 8
    joint_goal[3] = -math.pi / 2
    joint_goal[5] = math.pi / 3
    if not group.go(joint_goal, wait=True):
        print(group.get_last_outcome().error_code.message)
        return 1

    pose_goal = geometry_msgs.msg.Pose()
    pose_goal.orientation.x = 1.0
    pose_goal.position.x = 0.4
    pose_goal.position.y = 0.1
    pose_goal.position.z = 0.4
    group.set_pose_target(pose_goal)
    success, trajectory, planning_time, error_code = group.plan()
    print(error_code.message, f"({len(trajectory.joint_trajectory.points)} points, {planning_time:.3f} s)")
    print(group.get_last_result().certificate)
    if not success or not group.execute(trajectory, wait=True):
        return 1
    group.stop()
    group.clear_pose_targets()
    reached = group.get_current_pose().pose.position
    print(
        f"at {reached.x:.4f} {reached.y:.4f} {reached.z:.4f}: {group.get_last_outcome().error_code.message}"
    )
    moveit_commander.roscpp_shutdown()
    return 0


if __name__ == "__main__":
    with moveit_commander.World("panda"):
        sys.exit(main())
