"""Smallest singular value and manipulability of a frame's Jacobian."""

from dataclasses import dataclass

import numpy as np

from trajopt.optimise.terms.frame_jacobian import FrameJacobian, frame_jacobian
from trajopt.optimise.terms.requirement import INSET, constrain
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import SingularityDistance
from trajopt.problem.requirements.singularity_distance import LENGTH
from trajopt.problem.residual import WHOLE, Constraint, Cost, Window, constraint
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Loss, Rows
from trajopt.values.errors.arguments import checked


@dataclass(frozen=True, eq=False)
class SmallestSingularValue:
    """One component: the smallest singular value s of a frame's Jacobian [m/rad; m/m].

    s' = u . J' v with its singular vectors u and v; exact where the value is single.

    Attributes:
        reduced: The robot and its surroundings.
        required: What is required.
    """

    reduced: ReducedModel
    required: SingularityDistance

    @property
    def name(self) -> str:
        """The frame that may move."""
        return f"distance of {self.required.frame} from singularity"

    def linearise(self, motion: Motion) -> Rows:
        """Evaluate and differentiate at all samples."""
        need = self.required
        at = frame_jacobian(self.reduced, motion, need.frame, length=need.length, offset=need.offset)
        values, slopes = singular_values(at)
        return motion.rows_of_all(values[:, -1:], slopes[:, -1:])


@checked
@dataclass(frozen=True, eq=False)
class LostManipulability:
    """One component: r / (r + m), from 1 at a singularity towards 0 far from it, with reference r.

    Yoshikawa's manipulability m is the product of the singular values of the Jacobian, the volume of the
    ellipsoid of velocities. Source: Yoshikawa, Manipulability of robotic mechanisms, IJRR 1985.

    Attributes:
        frame: Link, tool frame or attached object.
        reference: Manipulability r at which half is lost, > 0.
        length: Length that a radian of rotation counts as [m]; 0 where only the origin's motion counts.
    """

    frame: str
    reference: float
    length: float

    @property
    def name(self) -> str:
        """The frame that may move."""
        return f"lost manipulability of {self.frame}"

    def linearise(self, motion: Motion) -> Rows:
        """Evaluate and differentiate at all samples."""
        at = frame_jacobian(motion.query.reduced, motion, self.frame, length=self.length, offset=np.zeros(3))
        values, slopes = singular_values(at)
        volume = values.prod(axis=1)
        rate = np.zeros((len(values), slopes.shape[2]))
        for place in range(values.shape[1]):
            others = np.delete(values, place, axis=1).prod(axis=1)
            rate += others[:, None] * slopes[:, place]
        lost = self.reference / (self.reference + volume)
        rate = -(lost**2 / self.reference)[:, None] * rate
        return motion.rows_of_all(lost[:, None], rate[:, None, :])


@checked
def manipulability(
    frame: str,
    *,
    reference: float,
    weight: float = 1e-3,
    length: float = LENGTH,
    loss: Loss = Loss.SQUARED,
    window: Window = WHOLE,
) -> Cost:
    """Push a motion away from singular configurations: a `Cost` that counts at every sample.

    Args:
        frame: Link, tool frame or attached object.
        reference: Manipulability at which half of the cost is left, > 0.
        weight: Of the cost at a singularity.
        length: What a radian of rotation is weighed as [m]; 0 where only the origin's motion counts.
        loss: Squared by default.
        window: Where it counts.
    """
    return Cost(LostManipulability(frame, reference, length), weight, loss, window)


def singular_values(at: FrameJacobian) -> tuple[Floats, Floats]:
    """Return all singular values, largest first, (S, k), and their derivatives, (S, k, n)."""
    left, values, right = np.linalg.svd(at.matrix, full_matrices=False)
    slopes = np.einsum("sdk,sdji,skj->ski", left, at.slope, right, optimize=True)
    return values, slopes


@constrain.register
def _(
    required: SingularityDistance, reduced: ReducedModel, window: Window, inset: float = INSET
) -> tuple[Constraint, ...]:
    return (
        constraint(
            SmallestSingularValue(reduced, required),
            lower=required.smallest * (1.0 + inset),
            upper=np.inf,
            tolerance=max(required.smallest * inset * 0.5, 1e-9),
            window=window,
        ),
    )
