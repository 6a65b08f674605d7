"""Stands for `tf.transformations`: quaternions (x, y, z, w) and Euler angles."""

from collections.abc import Sequence
from typing import Any

from scipy.spatial.transform import Rotation

from trajopt.arrays import Floats
from trajopt.errors import ShapeError, shown

AXES = "sxyz"


def _order(axes: str) -> Any:
    """Return scipy's name of an order of turns: s means fixed axes, r turning ones."""
    if len(axes) != 4 or axes[0] not in "sr" or not set(axes[1:]) <= set("xyz"):
        raise ShapeError("axes", f"must be s or r and three of x, y, z, such as 'sxyz'; is {shown(axes)}")
    return axes[1:] if axes[0] == "s" else axes[1:].upper()


def quaternion_from_euler(ai: float, aj: float, ak: float, axes: str = AXES) -> Floats:
    """Return the quaternion (x, y, z, w) of three turns [rad].

    Args:
        ai: First angle; roll for the default axes.
        aj: Second angle; pitch.
        ak: Third angle; yaw.
        axes: Their axes, s for fixed ones in front or r for ones that turn along.

    Raises:
        ShapeError: If the axes are none.
    """
    return Rotation.from_euler(_order(axes), (ai, aj, ak)).as_quat()


def euler_from_quaternion(quaternion: Sequence[float], axes: str = AXES) -> tuple[float, float, float]:
    """Return the three turns [rad] of a quaternion (x, y, z, w).

    Raises:
        ShapeError: If the axes are none.
    """
    angles: Floats = Rotation.from_quat(list(quaternion)).as_euler(_order(axes))
    return float(angles[0]), float(angles[1]), float(angles[2])
