"""Forms of a rotation: matrix, quaternion, roll-pitch-yaw, rotation vector."""

from math import atan2, cos, hypot, sin

import numpy as np

from trajopt.values.arrays import Floats

_GIMBAL = 1e-9
"""Where the cosine of the pitch is smaller, roll and yaw turn about one axis."""


def from_rpy(roll: float, pitch: float, yaw: float) -> Floats:
    """Return the matrix (3, 3) of turns about the fixed axes x, y, z in this order [rad]."""
    (cr, sr), (cp, sp), (cy, sy) = ((cos(angle), sin(angle)) for angle in (roll, pitch, yaw))
    return np.array(
        (
            (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
            (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
            (-sp, cp * sr, cp * cr),
        )
    )


def from_quaternion(x: float, y: float, z: float, w: float) -> Floats:
    """Return the matrix (3, 3) of a unit quaternion."""
    return np.array(
        (
            (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)),
            (2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)),
            (2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)),
        )
    )


def as_quaternion(rotation: Floats) -> Floats:
    """Return the unit quaternion (x, y, z, w), shape (4,), w >= 0, of a matrix (3, 3).

    The largest of the four is found first, so that nothing is divided by a small number. Source: Shepperd,
    Quaternion from rotation matrix, Journal of Guidance and Control 1978.
    """
    a, b, c = np.diagonal(rotation).tolist()
    squares = np.array((1.0 + a - b - c, 1.0 - a + b - c, 1.0 - a - b + c, 1.0 + a + b + c))
    products = np.empty((4, 4))  # of the parts, four times each
    products[:3, :3] = rotation + rotation.T
    products[3, :3] = products[:3, 3] = (
        rotation[2, 1] - rotation[1, 2],
        rotation[0, 2] - rotation[2, 0],
        rotation[1, 0] - rotation[0, 1],
    )
    np.fill_diagonal(products, squares)
    parts = products[int(np.argmax(squares))]
    parts = parts / np.linalg.norm(parts)
    return -parts if parts[3] < 0.0 else parts


def as_rpy(rotation: Floats) -> tuple[float, float, float]:
    """Return roll, pitch and yaw [rad] of a matrix (3, 3); no yaw where roll does the same."""
    (r00, r01, _), (r10, r11, _), (r20, r21, r22) = rotation.tolist()
    level = hypot(r00, r10)
    pitch = atan2(-r20, level)
    if level < _GIMBAL:
        return atan2(-r01 if r20 > 0.0 else r01, r11), pitch, 0.0
    return atan2(r21, r22), pitch, atan2(r10, r00)


def from_rotation_vector(vector: Floats) -> Floats:
    """Return the matrix (3, 3) of a turn about a vector (3,) by its length [rad], by Rodrigues' formula."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = (vector / angle).tolist()
    cross = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
    return np.eye(3) + sin(angle) * cross + (1.0 - cos(angle)) * cross @ cross


def as_rotation_vector(rotation: Floats) -> Floats:
    """Return the rotation vector (3,) of a matrix (3, 3), of length 0 to pi [rad]."""
    quaternion = as_quaternion(rotation)
    sine = float(np.linalg.norm(quaternion[:3]))
    if sine == 0.0:
        return np.zeros(3)
    return 2.0 * atan2(sine, float(quaternion[3])) / sine * quaternion[:3]
