"""UFACTORY xArm7, without a gripper."""

from pathlib import Path

import trajopt as to

from .._example_robot_data import share_folder

__all__ = ["load"]

_HERE = Path(__file__).parent
_URDF = "example-robot-data/robots/xarm_description/urdf/xarm7.urdf"


def load() -> to.Robot:
    """Load the xArm7: seven joints [rad], four of them with two turns of range.

    Group ``xarm7``; states ``home`` and ``hold-up``; tool frame ``link_eef``, the tool
    flange.

    Returns:
        The robot. The jerk limits are planning values, not ratings.

    Raises:
        MissingExtra: if ``example-robot-data`` is not installed.
    """
    share = share_folder()
    return to.Robot.from_urdf(
        share / _URDF,
        srdf=_HERE / "xarm7.srdf",
        limits=_HERE / "joint_limits.yaml",
        package_dirs=(share,),
        name="xarm7",
    )
