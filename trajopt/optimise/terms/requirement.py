"""From requirements (plain data) to constraints: each term's module registers its own."""

from dataclasses import dataclass
from functools import singledispatch

import numpy as np

from trajopt.problem.motion import Motion
from trajopt.problem.requirement import registered
from trajopt.problem.requirements import Requirement
from trajopt.problem.residual import WHOLE, Constraint, Cost, Window
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Loss, Rows
from trajopt.values.errors import shown
from trajopt.values.errors.arguments import checked

INSET = 0.1
"""Share of a tolerance that the program keeps in reserve, since rounded corners use up some of it."""


@singledispatch
def constrain(
    required: Requirement, reduced: ReducedModel, window: Window, inset: float = INSET
) -> tuple[Constraint, ...]:
    """Return the constraints that make a motion hold a requirement.

    Args:
        window: Part of the motion in which it must hold.
        inset: Share of each tolerance to keep in reserve.

    Raises:
        ProblemError: If no term is registered for this kind of requirement.
    """
    return registered(constrain, type(required), "term")(required, reduced, window, inset)


@dataclass(frozen=True, eq=False)
class Exceeded:
    """Excess of each number of a requirement over the nearer of its bounds; negative within."""

    required: Requirement

    @property
    def name(self) -> str:
        return f"excess of {shown(self.required)}"

    def linearise(self, motion: Motion) -> Rows:
        found: list[Rows] = []
        offset = 0
        for item in constrain(self.required, motion.query.reduced, WHOLE, inset=0.0):
            rows = item.residual.linearise(motion)
            lower, upper = item.bounds(rows)
            bounded = np.isfinite(lower) | np.isfinite(upper)
            above = (rows.value - upper) >= (lower - rows.value)
            value = np.where(above, rows.value - upper, lower - rows.value)
            jacobian = np.where(above, 1.0, -1.0)[:, None, None] * rows.jacobian
            found.append(
                Rows(
                    value[bounded],
                    jacobian[bounded],
                    rows.knots[bounded],
                    rows.component[bounded] + offset,
                    rows.place[bounded],
                )
            )
            offset += int(rows.component.max(initial=-1)) + 1
        if not found:  # nothing of it moves
            samples, joints = motion.positions.shape
            return motion.rows_of_all(np.empty((samples, 0)), np.empty((samples, 0, joints)))
        return Rows(
            np.concatenate([rows.value for rows in found]),
            np.concatenate([rows.jacobian for rows in found]),
            np.concatenate([rows.knots for rows in found]),
            np.concatenate([rows.component for rows in found]),
            np.concatenate([rows.place for rows in found]),
        )


@checked
def penalty(required: Requirement, weight: float, *, loss: Loss = Loss.HINGE, window: Window = WHOLE) -> Cost:
    """Penalise a requirement instead of enforcing it: a `Cost` on the excess over its tolerances.

    Args:
        weight: Of every row, in the unit of each (metres, radians).
        loss: By default a hinge, which is zero within the tolerances.
        window: Part of the motion in which it counts.
    """
    return Cost(Exceeded(required), weight, loss, window)
