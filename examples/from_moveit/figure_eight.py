"""A Cartesian path: a figure of eight over the table, with the tool pointing down."""

import math
import sys

from trajopt.ros import commander as moveit_commander
from trajopt.ros.commander import geometry_msgs


def main() -> int:
    """Go to the beginning of the figure, and follow it."""
    group = moveit_commander.MoveGroupCommander("panda_arm")
    group.set_end_effector_link("panda_hand_tcp")
    group.set_max_velocity_scaling_factor(0.4)
    group.set_max_acceleration_scaling_factor(0.4)

    down = geometry_msgs.msg.Quaternion(1.0, 0.0, 0.0, 0.0)
    waypoints: list[geometry_msgs.msg.Pose] = []
    for count in range(49):
        phase = 2.0 * math.pi * count / 48
        point = geometry_msgs.msg.Point(0.45 + 0.06 * math.sin(2.0 * phase), 0.15 * math.sin(phase), 0.25)
        waypoints.append(geometry_msgs.msg.Pose(point, down))
    if not group.go(waypoints[0], wait=True):
        print(group.get_last_outcome().error_code.message)
        return 1

    trajectory, fraction = group.compute_cartesian_path(waypoints, 0.01)
    followed = group.get_last_followed()
    print(f"{fraction:.0%} followed: {followed.explain()}")
    print(followed.certificate)
    if fraction < 1.0 or not group.execute(trajectory, wait=True):
        return 1
    print(group.get_last_outcome().error_code.message)
    return 0


if __name__ == "__main__":
    with moveit_commander.World("panda"):
        sys.exit(main())
