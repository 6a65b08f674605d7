"""Placements of frames relative to other frames at all samples, with their derivatives."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.geometry import angular_jacobian, point_jacobian
from trajopt.problem.motion import Motion
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats
from trajopt.values.placement import Placement


@dataclass(frozen=True, eq=False)
class RelativeFrame:
    """A point and orientation of one frame, seen from another, at S samples.

    Attributes:
        point: Shape (S, 3) [m].
        rotation: Shape (S, 3, 3).
        point_jacobian: Derivative of the point, shape (S, 3, n).
        angular_jacobian: Angular velocity relative to and seen from the reference, (S, 3, n).
    """

    point: Floats
    rotation: Floats
    point_jacobian: Floats
    angular_jacobian: Floats

    def seen_from(self, places: Sequence[Placement]) -> "RelativeFrame":
        """Return it as seen from a frame moved by time, placed at `places` in the reference."""
        inward = np.stack([place.rotation.T for place in places])
        origin = np.stack([place.translation for place in places])
        return RelativeFrame(
            (inward @ (self.point - origin)[:, :, None])[:, :, 0],
            inward @ self.rotation,
            inward @ self.point_jacobian,
            inward @ self.angular_jacobian,
        )


def relative_frame(
    reduced: ReducedModel, motion: Motion, frame: str, reference: str, offset: Floats
) -> RelativeFrame:
    """Evaluate a point of a frame and its orientation, seen from a reference that may move.

    Args:
        reference: "world", link, tool frame or object.
        offset: The point, in the frame, shape (3,) [m].
    """
    kinematics, model = motion.kinematics, motion.query.reduced
    joint, held = reduced.attachment(frame)
    rotation = kinematics.rotation[:, joint] @ held.rotation
    point = kinematics.rotation[:, joint] @ (held * offset) + kinematics.translation[:, joint]
    count = len(point)
    velocity = point_jacobian(model, kinematics.jacobian, np.full(count, joint), point)
    spin = angular_jacobian(model, kinematics.jacobian, joint)
    base, base_held = reduced.attachment(reference)
    if base == 0:  # it stands still
        to_base = base_held.rotation.T
        origin = base_held.translation
    else:
        velocity -= point_jacobian(model, kinematics.jacobian, np.full(count, base), point)
        spin -= angular_jacobian(model, kinematics.jacobian, base)
        to_base = np.swapaxes(kinematics.rotation[:, base] @ base_held.rotation, 1, 2)
        origin = kinematics.rotation[:, base] @ base_held.translation + kinematics.translation[:, base]
    return RelativeFrame(
        (to_base @ (point - origin)[:, :, None])[:, :, 0],
        to_base @ rotation,
        to_base @ velocity,
        to_base @ spin,
    )


ZERO = 1e-12
"""A shorter vector has no direction."""


def lengths(vectors: Floats, rate: Floats, aside: int | None = None) -> tuple[Floats, Floats]:
    """Return the lengths of vectors (s, d), shape (s,), and their derivatives, shape (s, n).

    The length of a zero vector has no derivative: zero is used, or the rate along `aside` if it must grow.

    Args:
        rate: Derivatives of the vectors, shape (s, d, n).
        aside: The axis along which zero vectors are taken to grow.
    """
    length = np.linalg.norm(vectors, axis=1)
    unit = vectors / np.maximum(length, ZERO)[:, None]
    if aside is not None:
        unit[length < ZERO] = np.eye(vectors.shape[1])[aside]
    return length, np.einsum("sd,sdn->sn", unit, rate)
