"""Franka Emika Panda with the Franka Hand."""

from pathlib import Path

import trajopt as to

from .._example_robot_data import share_folder

__all__ = ["load"]

_HERE = Path(__file__).parent
_URDF = "example-robot-data/robots/panda_description/urdf/panda.urdf"


def load() -> to.Robot:
    """Load the Panda: seven arm joints [rad] and two finger joints [m].

    Groups ``panda_arm``, ``panda_manipulator``, ``hand`` and ``panda_arm_hand``; states
    ``ready``, ``extended``, ``transport`` (arm), ``open``, ``close`` (hand); tool frame
    ``panda_hand_tcp``, between the fingertips.

    Returns:
        The robot, with the limits Franka publishes for its control interface.

    Raises:
        MissingExtra: if ``example-robot-data`` is not installed.
    """
    share = share_folder()
    return to.Robot.from_urdf(
        share / _URDF,
        srdf=_HERE / "panda.srdf",
        limits=_HERE / "joint_limits.yaml",
        package_dirs=(share,),
        name="panda",
    )
