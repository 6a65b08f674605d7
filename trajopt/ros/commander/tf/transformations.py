"""Stand-in for `tf.transformations`: quaternions (x, y, z, w), Euler angles and 4x4 matrices."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from trajopt.values.arrays import Floats
from trajopt.values.errors import ShapeError, shown

AXES = "sxyz"


def _order(axes: str) -> Any:
    if len(axes) != 4 or axes[0] not in "sr" or not set(axes[1:]) <= set("xyz"):
        raise ShapeError("axes", f"must be s or r and three of x, y, z, such as 'sxyz'; is {shown(axes)}")
    return axes[1:] if axes[0] == "s" else axes[1:].upper()


def quaternion_from_euler(ai: float, aj: float, ak: float, axes: str = AXES) -> Floats:
    """Return the quaternion (x, y, z, w) of angles [rad]; "s" for static axes, "r" for rotating ones."""
    return Rotation.from_euler(_order(axes), (ai, aj, ak)).as_quat()


def euler_from_quaternion(quaternion: Sequence[float], axes: str = AXES) -> tuple[float, float, float]:
    """Return the three turns [rad] of a quaternion (x, y, z, w)."""
    angles: Floats = Rotation.from_quat(list(quaternion)).as_euler(_order(axes))
    return float(angles[0]), float(angles[1]), float(angles[2])


def quaternion_multiply(quaternion1: Sequence[float], quaternion0: Sequence[float]) -> Floats:
    """Return the product of two quaternions: the second rotation, followed by the first."""
    return (Rotation.from_quat(list(quaternion1)) * Rotation.from_quat(list(quaternion0))).as_quat()


def quaternion_inverse(quaternion: Sequence[float]) -> Floats:
    return Rotation.from_quat(list(quaternion)).inv().as_quat()


def quaternion_about_axis(angle: float, axis: Sequence[float]) -> Floats:
    """Return the quaternion of a turn [rad] about an axis of any length but zero."""
    along = np.array(axis, dtype=np.float64)
    return Rotation.from_rotvec(angle * along / np.linalg.norm(along)).as_quat()


def quaternion_matrix(quaternion: Sequence[float]) -> Floats:
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(list(quaternion)).as_matrix()
    return matrix


def quaternion_from_matrix(matrix: Floats) -> Floats:
    return Rotation.from_matrix(np.array(matrix)[:3, :3]).as_quat()


def euler_matrix(ai: float, aj: float, ak: float, axes: str = AXES) -> Floats:
    return quaternion_matrix(quaternion_from_euler(ai, aj, ak, axes).tolist())


def euler_from_matrix(matrix: Floats, axes: str = AXES) -> tuple[float, float, float]:
    return euler_from_quaternion(quaternion_from_matrix(matrix).tolist(), axes)


def translation_matrix(direction: Sequence[float]) -> Floats:
    matrix = np.eye(4)
    matrix[:3, 3] = direction
    return matrix


def translation_from_matrix(matrix: Floats) -> Floats:
    return np.array(matrix, dtype=np.float64)[:3, 3]
