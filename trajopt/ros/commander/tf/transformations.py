"""Stand-in for `tf.transformations`: quaternions (x, y, z, w), Euler angles and 4x4 matrices."""

from collections.abc import Sequence
from functools import reduce
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


def quaternion_conjugate(quaternion: Sequence[float]) -> Floats:
    return np.array(quaternion, dtype=np.float64) * (-1.0, -1.0, -1.0, 1.0)


def quaternion_slerp(quat0: Sequence[float], quat1: Sequence[float], fraction: float) -> Floats:
    """Return the quaternion at a fraction of the shorter turn from one to another."""
    first = Rotation.from_quat(list(quat0))
    turn: Any = first.inv() * Rotation.from_quat(list(quat1))
    return (first * Rotation.from_rotvec(fraction * turn.as_rotvec())).as_quat()


def quaternion_about_axis(angle: float, axis: Sequence[float]) -> Floats:
    """Return the quaternion of a turn [rad] about an axis of any length but zero."""
    return Rotation.from_rotvec(angle * unit_vector(axis)).as_quat()


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


def identity_matrix() -> Floats:
    return np.eye(4)


def inverse_matrix(matrix: Floats) -> Floats:
    return np.array(np.linalg.inv(np.array(matrix)), dtype=np.float64)


def concatenate_matrices(*matrices: Floats) -> Floats:
    """Return the product of matrices, the last applied first."""
    return reduce(np.dot, matrices, np.eye(4))


def rotation_matrix(angle: float, direction: Sequence[float], point: Sequence[float] | None = None) -> Floats:
    """Return the matrix of a turn [rad] about an axis through a point, by default the origin."""
    turn = quaternion_matrix(quaternion_about_axis(angle, direction).tolist())
    there = identity_matrix() if point is None else translation_matrix(point)
    return there @ turn @ inverse_matrix(there)


def unit_vector(data: Sequence[float]) -> Floats:
    vector = np.array(data, dtype=np.float64)
    return vector / np.linalg.norm(vector)
