"""The pose of one frame relative to another (an element of SE(3)), and rotations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import atan2, cos, hypot, sin
from typing import TypeAlias, cast, overload

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from trajopt.values.arrays import Floats, Value, floats, readonly
from trajopt.values.errors import ShapeError, SizeError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.likely_units import stated_angles

WORLD = "world"


FARTHEST = 1e6
"""Largest coordinate of a placement [m]."""


@dataclass(frozen=True, eq=False)
class Placement(Value):
    """Rotation and translation of a frame relative to a reference frame.

    A point with coordinates x in the placed frame has `rotation @ x + translation` in the
    reference frame.

    Attributes:
        rotation: Rotation matrix, shape (3, 3), read-only.
        translation: Origin of the placed frame, shape (3,) [m], read-only.
    """

    rotation: Floats = field(default_factory=lambda: readonly(np.eye(3)))
    translation: Floats = field(default_factory=lambda: readonly(np.zeros(3)))

    @overload
    def __mul__(self, other: Placement) -> Placement: ...
    @overload
    def __mul__(self, other: Floats) -> Floats: ...
    def __mul__(self, other: Placement | Floats) -> Placement | Floats:
        if other is IDENTITY:
            return self
        if isinstance(other, Placement):
            if self is IDENTITY:
                return other
            return Placement(
                readonly(self.rotation @ other.rotation),
                readonly(self.rotation @ other.translation + self.translation),
            )
        return other @ self.rotation.T + self.translation

    def inverse(self) -> Placement:
        """Return the placement of the reference frame relative to the placed frame."""
        return Placement(readonly(self.rotation.T.copy()), readonly(-self.rotation.T @ self.translation))

    @property
    def quaternion(self) -> Floats:
        """Unit quaternion (x, y, z, w), shape (4,), w >= 0."""
        return as_quaternion(self.rotation)

    @property
    def rpy(self) -> tuple[float, float, float]:
        """Roll, pitch, yaw about the fixed axes x, y, z in this order [rad]."""
        return as_rpy(self.rotation)

    @property
    def homogeneous(self) -> Floats:
        """Homogeneous matrix, shape (4, 4)."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation
        matrix[:3, 3] = self.translation
        return matrix

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Placement)
            and np.array_equal(self.rotation, other.rotation)
            and np.array_equal(self.translation, other.translation)
        )

    def __hash__(self) -> int:
        return hash((self.rotation.tobytes(), self.translation.tobytes()))

    def __str__(self) -> str:
        xyz = ", ".join(f"{value + 0.0:.4g}" for value in self.translation.round(4).tolist())
        rpy = [f"{value + 0.0:.4g}" for value in np.rad2deg(self.rpy).round(2).tolist()]
        turned = "" if rpy == ["0", "0", "0"] else f" turned by rpy ({', '.join(rpy)}) deg"
        return f"({xyz}) m{turned}"

    def __repr__(self) -> str:
        x, y, z = (round(float(value), 6) + 0.0 for value in self.translation)
        roll, pitch, yaw = (round(value, 6) + 0.0 for value in self.rpy)
        return f"placement(xyz=({x}, {y}, {z}), rpy=({roll}, {pitch}, {yaw}))"


PlacementLike: TypeAlias = Placement | pin.SE3 | ArrayLike | tuple[ArrayLike, ArrayLike]
"""Accepted as a placement: a `Placement`, Pinocchio's SE3, a homogeneous matrix of shape (4, 4), or a
pair (position [m], quaternion (x, y, z, w)).
"""

IDENTITY = Placement()
"""The identity; composing with it costs nothing."""


@checked
def placement(
    xyz: ArrayLike = (0.0, 0.0, 0.0),
    *,
    rpy: ArrayLike | None = None,
    quaternion: ArrayLike | None = None,
    rotation: ArrayLike | None = None,
    degrees: bool = False,
) -> Placement:
    """Place a frame by its position and one form of its orientation; the identity if none is given.

    Args:
        xyz: Position of the frame's origin, shape (3,) [m].
        rpy: Roll, pitch, yaw about the fixed axes x, y, z in this order (URDF's), shape (3,) [rad].
        quaternion: (x, y, z, w), shape (4,); it is normalised.
        rotation: Rotation matrix, shape (3, 3), orthonormal to 1e-6, right-handed.

    Raises:
        ShapeError: If a number is not finite, the quaternion is zero, the matrix is not a rotation, or more
            than one orientation is given.
        SizeError: If the position is farther than 1e6 m: there rounding exceeds a micrometre.
        ProblemError: If `degrees` is neither true nor false.

    Warns:
        UnitWarning: If an angle in radians is beyond a whole turn.
    """
    translation = floats("xyz", xyz, (3,))
    if np.abs(translation).max() > FARTHEST:
        raise SizeError("xyz", f"is {translation.tolist()} m; {FARTHEST:g} m is the farthest")
    if sum(value is not None for value in (rpy, quaternion, rotation)) > 1:
        raise ShapeError("orientation", "give one of rpy, quaternion and rotation, not several")
    matrix = np.eye(3)
    if rpy is not None:
        matrix = from_rpy(*stated_angles("rpy", rpy, (3,), degrees=degrees).tolist())
    elif quaternion is not None:
        parts = floats("quaternion", quaternion, (4,))
        length = float(np.linalg.norm(parts))
        if length < 1e-9:
            raise ShapeError("quaternion", "has no length, so it is not an orientation")
        matrix = from_quaternion(*(parts / length).tolist())
    elif rotation is not None:
        matrix = _rotation("rotation", rotation)
    return Placement(readonly(matrix), translation)


def as_placement(name: str, value: PlacementLike) -> Placement:
    """Convert an argument to a placement; its name is for the error.

    Raises:
        ShapeError: If it is none of these, a number is not finite, or its rotation is invalid.
        SizeError: If its position is farther than 1e6 m.
    """
    if value is IDENTITY:
        return IDENTITY
    if isinstance(value, Placement):
        _rotation(f"{name}.rotation", value.rotation)
        floats(f"{name}.translation", value.translation, (3,))
        return value
    stated = cast("Sequence[ArrayLike]", value)
    try:
        if isinstance(value, pin.SE3):
            return placement(value.translation, rotation=value.rotation)
        if isinstance(value, list | tuple) and len(stated) == 2:
            return placement(stated[0], quaternion=stated[1])
        matrix = floats("matrix", cast("ArrayLike", value), (4, 4))
        if np.abs(matrix[3] - (0.0, 0.0, 0.0, 1.0)).max() > 1e-6:
            transposed = np.abs(matrix[:, 3] - (0.0, 0.0, 0.0, 1.0)).max() <= 1e-6
            hint = ": it is transposed, give matrix.T" if transposed else ""
            raise ShapeError("matrix", f"its last row is {matrix[3].tolist()}, not (0, 0, 0, 1){hint}")
        return placement(matrix[:3, 3], rotation=matrix[:3, :3])
    except SizeError as error:
        raise SizeError(name, str(error)) from error
    except ShapeError as error:
        forms = "a Placement, a pinocchio.SE3, a 4x4 matrix or (xyz, quaternion xyzw)"
        # A position is no placement by itself: unturned is right for most objects and for hardly any hand.
        alone = isinstance(value, list | tuple | np.ndarray) and len(stated) == 3 and np.ndim(stated[0]) == 0
        why = f"a position alone; placement({shown(stated)}) is unturned" if alone else str(error)
        raise ShapeError(name, f"must be {forms}, is {shown(stated)} ({why})") from error


def _rotation(name: str, value: ArrayLike) -> Floats:
    matrix = np.array(floats(name, value, (3, 3)))
    far = np.abs(matrix).max() > 2.0  # before its square overflows
    if far or np.abs(matrix @ matrix.T - np.eye(3)).max() > 1e-6 or np.linalg.det(matrix) < 0.0:
        raise ShapeError(name, "is not orthonormal and right-handed")
    return matrix


_GIMBAL = 1e-9
"""Below this cosine of the pitch, roll and yaw are about the same axis."""


def from_rpy(roll: float, pitch: float, yaw: float) -> Floats:
    """Return the rotation matrix (3, 3) of roll, pitch and yaw about the fixed axes x, y, z [rad]."""
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

    The largest of the four is computed first, so that no division is by a small number. Source: Shepperd,
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


def scalar_first(where: Placement) -> Floats:
    """Return the unit quaternion (w, x, y, z) of a placement, shape (4,), as MuJoCo and viser write it."""
    return np.roll(where.quaternion, 1)


def as_rpy(rotation: Floats) -> tuple[float, float, float]:
    """Return roll, pitch and yaw [rad] of a matrix (3, 3); yaw is zero in gimbal lock."""
    (r00, r01, _), (r10, r11, _), (r20, r21, r22) = rotation.tolist()
    level = hypot(r00, r10)
    pitch = atan2(-r20, level)
    if level < _GIMBAL:
        return atan2(-r01 if r20 > 0.0 else r01, r11), pitch, 0.0
    return atan2(r21, r22), pitch, atan2(r10, r00)


def from_rotation_vector(vector: Floats) -> Floats:
    """Return the rotation matrix (3, 3) of a rotation vector (3,) [rad], by Rodrigues' formula."""
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
