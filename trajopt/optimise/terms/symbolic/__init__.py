"""Placements of frames as CasADi expressions, built from the model's joints, and residuals made of them."""

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import casadi as ca
import numpy as np
import pinocchio as pin

from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, floats
from trajopt.values.placement import WORLD

SMALL = 1e-16
"""Squared lengths below this count as this, so that a root has a slope everywhere."""


class SymbolicKinematics:
    """Forward kinematics of a reduced model as expressions.

    Derivatives: `casadi.jacobian(expression, k.q)`.

    Attributes:
        q: The group's positions, symbols, shape (n, 1) [rad | m].
    """

    def __init__(self, reduced: ReducedModel) -> None:
        """Compose the placements of all joints from the world outwards.

        A joint turns about (or slides along) a fixed unit axis a of its own frame; rotation by
        Rodrigues' formula R = 1 + sin(t) [a] + (1 - cos(t)) [a]^2.
        """
        self.reduced = reduced
        self.q = ca.SX.sym("q", len(reduced.joint_names))
        model = reduced.model
        values = ca.SX(reduced.mimic_matrix) @ self.q + ca.SX(reduced.mimic_offset)
        neutral = pin.neutral(model)
        rotations, translations = [ca.SX.eye(3)], [ca.SX(np.zeros(3))]
        for number, joint in enumerate(list(model.joints)[1:], start=1):
            data = joint.createData()
            joint.calc(data, neutral)
            subspace = np.asarray(data.S, dtype=np.float64).reshape(6)
            value = values[joint.idx_v]
            fixed, parent = model.jointPlacements[number], int(model.parents[number])
            rotation = rotations[parent] @ ca.SX(fixed.rotation)
            translation = translations[parent] + rotations[parent] @ ca.SX(fixed.translation)
            rotations.append(rotation @ _turn(subspace[3:], value))
            translations.append(translation + rotation @ (ca.SX(subspace[:3]) * value))
        self._rotations, self._translations = tuple(rotations), tuple(translations)

    def rotation(self, frame: str, reference: str = WORLD) -> ca.SX:
        """Return the rotation of a frame, seen from a reference, shape (3, 3)."""
        mine = self._in_world(frame)[0]
        return mine if reference == WORLD else self._in_world(reference)[0].T @ mine

    def point(
        self, frame: str, offset: Sequence[float] | Floats = (0.0, 0.0, 0.0), reference: str = WORLD
    ) -> ca.SX:
        """Return a point of a frame, seen from a reference, shape (3, 1) [m].

        Args:
            offset: The point, in the frame [m].
            reference: "world", link, tool frame or object; it may move.

        Raises:
            FrameNotFound: If a frame is unknown.
            ShapeError: If the offset is not three finite numbers.
        """
        rotation, origin = self._in_world(frame)
        point = origin + rotation @ ca.SX(floats("offset", offset, (3,)))
        if reference == WORLD:
            return point
        turned, base = self._in_world(reference)
        return turned.T @ (point - base)

    def joint_point(self, joint: int, offset: Floats) -> ca.SX:
        return self._translations[joint] + self._rotations[joint] @ ca.SX(offset)

    def _in_world(self, frame: str) -> tuple[ca.SX, ca.SX]:
        joint, held = self.reduced.attachment(frame)
        rotation, origin = self._rotations[joint], self._translations[joint]
        return rotation @ ca.SX(held.rotation), origin + rotation @ ca.SX(held.translation)


def _turn(axis: Floats, angle: ca.SX) -> ca.SX:
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return ca.SX.eye(3) + ca.sin(angle) * ca.SX(cross) + (1.0 - ca.cos(angle)) * ca.SX(cross @ cross)


@runtime_checkable
class Symbolic(Protocol):
    """A residual with an expression: the same numbers, with automatic derivatives of any order.

    Others are measured (clearance, lines of sight, singular values) or plain functions.
    """

    def expression(self, kinematics: SymbolicKinematics) -> ca.SX:
        """Return the components at the configuration `kinematics.q`, a column."""
        ...


def length(vector: ca.SX) -> ca.SX:
    return ca.sqrt(ca.fmax(ca.sumsqr(vector), SMALL))
