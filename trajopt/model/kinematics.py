"""Where the links of a robot are at one posture: for building scenes, not for planning."""

import pinocchio as pin

from trajopt.arrays import Floats, readonly
from trajopt.model.named_frames import link_frame
from trajopt.model.placement import Placement
from trajopt.model.robot import Robot


def link_placement(robot: Robot, link: str, positions: Floats) -> Placement:
    """Return the placement of a link in the world.

    Args:
        robot: The robot.
        link: Name of one of its links.
        positions: Of all joints, shape (number of joints,) [rad | m].
    """
    data = robot.model.createData()
    frame = link_frame(robot.model, link)
    pin.framesForwardKinematics(robot.model, data, robot.configuration(positions))
    found = data.oMf[frame]
    return Placement(readonly(found.rotation.copy()), readonly(found.translation.copy()))
