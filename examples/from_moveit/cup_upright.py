"""A path constraint: a cup is carried from one side to the other without tilting."""

import sys

from trajopt.ros import commander as moveit_commander
from trajopt.ros.commander import geometry_msgs, moveit_msgs

TILT = 0.1


def main() -> int:
    """Carry the cup from side to side."""
    group = moveit_commander.MoveGroupCommander("panda_arm")
    robot = moveit_commander.RobotCommander()
    scene = moveit_commander.PlanningSceneInterface()
    group.set_end_effector_link("panda_hand_tcp")
    group.set_max_velocity_scaling_factor(0.6)
    group.set_max_acceleration_scaling_factor(0.6)

    cup = geometry_msgs.msg.PoseStamped()
    cup.header.frame_id = "panda_hand_tcp"
    cup.pose.orientation.w = 1.0
    touch_links = robot.get_link_names(group="hand")
    scene.attach_cylinder("panda_hand_tcp", "cup", cup, height=0.12, radius=0.03, touch_links=touch_links)

    start = group.get_current_pose().pose
    upright = moveit_msgs.msg.OrientationConstraint()
    upright.header.frame_id = "panda_link0"
    upright.link_name = group.get_end_effector_link()
    upright.orientation = start.orientation
    upright.absolute_x_axis_tolerance = TILT
    upright.absolute_y_axis_tolerance = TILT
    upright.absolute_z_axis_tolerance = 3.15  # It may turn about its own axis.
    upright.weight = 1.0
    constraints = moveit_msgs.msg.Constraints(name="upright", orientation_constraints=[upright])

    group.set_path_constraints(constraints)
    for y in (0.45, -0.45):
        goal = geometry_msgs.msg.Pose(geometry_msgs.msg.Point(0.35, y, 0.3), start.orientation)
        group.set_pose_target(goal)
        if not group.go(wait=True):  # Under the same constraints as plan() would be.
            print(group.get_last_outcome().error_code.message)
            return 1
        print(group.get_last_result().certificate)
    group.clear_path_constraints()
    return 0


if __name__ == "__main__":
    with moveit_commander.World("panda"):
        sys.exit(main())
