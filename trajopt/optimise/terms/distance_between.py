"""Distance between two points of frames."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from trajopt.optimise.terms.frames import lengths, relative_frame
from trajopt.optimise.terms.requirement import INSET, constrain
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import DistanceBetween
from trajopt.problem.residual import Constraint, Window, constraint
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Rows

if TYPE_CHECKING:
    import casadi as ca

    from trajopt.optimise.terms.symbolic import SymbolicKinematics

LARGE = 0.1
"""The reserve is a share of the range between the bounds, of this much at most [m]."""


@dataclass(frozen=True, eq=False)
class PointDistance:
    """Four components [m]: the first point as seen from the second along its frame's axes, and the distance.

    If the points coincide the distance is taken to grow along the frame's x axis.

    Attributes:
        reduced: The robot and its surroundings.
        required: The requirement.
    """

    reduced: ReducedModel
    required: DistanceBetween

    units = ("m",)

    @property
    def name(self) -> str:
        """The two frames."""
        return f"distance of {self.required.first} from {self.required.second}"

    def linearise(self, motion: Motion) -> Rows:
        """Evaluate and differentiate at all samples."""
        need = self.required
        seen = relative_frame(self.reduced, motion, need.first, need.second, need.first_offset)
        apart = seen.point - need.second_offset
        distance, rate = lengths(apart, seen.point_jacobian, aside=0)
        return motion.rows_of_all(
            np.hstack((apart, distance[:, None])),
            np.concatenate((seen.point_jacobian, rate[:, None]), axis=1),
        )

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
        """Return the components as an expression; see `Symbolic`."""
        import casadi as ca

        from trajopt.optimise.terms.symbolic import length

        need = self.required
        apart = kinematics.point(need.first, need.first_offset, need.second) - ca.SX(need.second_offset)
        return ca.vertcat(apart, length(apart))


@constrain.register
def _(
    required: DistanceBetween, reduced: ReducedModel, window: Window, inset: float = INSET
) -> tuple[Constraint, ...]:
    kept = inset * 0.5 * min(required.upper - required.lower, LARGE)
    # Without a lower bound an inset one would forbid that the points meet.
    lower = required.lower + kept if required.lower > 0.0 else -np.inf
    upper = required.upper - kept
    return (
        constraint(
            PointDistance(reduced, required),
            lower=(-upper, -upper, -upper, lower),
            upper=(upper, upper, upper, upper),
            tolerance=max(0.5 * kept, 1e-9),
            window=window,
        ),
    )
