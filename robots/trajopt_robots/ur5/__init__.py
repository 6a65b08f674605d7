"""Universal Robots UR5 (CB3 series), without a gripper."""

from pathlib import Path

import trajopt as to

from .._example_robot_data import share_folder

__all__ = ["load"]

_HERE = Path(__file__).parent
_URDF = "example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"


def load() -> to.Robot:
    """Load the UR5: six joints [rad], five of them with two turns of range.

    Groups ``manipulator`` and ``endeffector``; states ``home`` and ``up``; tool frame
    ``tool0``, the flange as the UR controller reports it.

    Returns:
        The robot. Acceleration and jerk limits are planning values, not ratings.

    Raises:
        MissingExtra: if ``example-robot-data`` is not installed.
    """
    share = share_folder()
    return to.Robot.from_urdf(
        share / _URDF,
        srdf=_HERE / "ur5.srdf",
        limits=_HERE / "joint_limits.yaml",
        package_dirs=(share,),
        name="ur5",
    )
