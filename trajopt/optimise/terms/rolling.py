"""The wheels of a base roll and do not slide sideways."""

from dataclasses import dataclass

import numpy as np

from trajopt.problem.motion import Motion
from trajopt.problem.residual import Constraint, constraint
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Rows, Value

SHARE = 0.1
"""Share of the drift that is accepted which the program's own tolerances may add up to."""


@dataclass(frozen=True, eq=False)
class Rolling(Value):
    """Motion of each step from knot to knot across the heading in its middle [m].

    The chord of an arc of a circle is along the heading in its middle, so arcs and straight lines hold it
    exactly, and smooth curves up to the third power of the step.

    Attributes:
        places: Of x, y and yaw among the group's joints.
    """

    places: tuple[int, int, int]
    name = "rolling"

    def linearise(self, motion: Motion) -> Rows:
        """Return a row a step, with its exact derivative."""
        knots, (x, y, yaw) = motion.knots, self.places
        step = np.diff(knots, axis=0)
        heading = (knots[1:, yaw] + knots[:-1, yaw]) / 2.0
        s, c = np.sin(heading), np.cos(heading)
        jacobian = np.zeros((len(step), 2, knots.shape[1]))
        for end, sign in ((0, -1.0), (1, 1.0)):
            jacobian[:, end, x], jacobian[:, end, y] = -sign * s, sign * c
            jacobian[:, end, yaw] = -0.5 * (c * step[:, x] + s * step[:, y])
        first = np.arange(len(step))
        return Rows(
            c * step[:, y] - s * step[:, x],
            jacobian,
            np.stack((first, first + 1), axis=1),
            np.zeros(len(step), dtype=np.int64),
            first.astype(np.float64) + 0.5,
        )


def rolling(reduced: ReducedModel, knots: int) -> tuple[Constraint, ...]:
    """Return the constraint that a base's wheels roll, if the group has such a base.

    Args:
        reduced: The model.
        knots: Number of knots of the motion.
    """
    base = reduced.scene.robot.base
    places = base.rolling(reduced.joint_names)
    if places is None:
        return ()
    return (constraint(Rolling(places), lower=0.0, upper=0.0, tolerance=SHARE * base.drift / knots),)
