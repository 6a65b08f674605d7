"""The wheels of a base roll and do not slide sideways."""

from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Value
from trajopt.errors import ProblemError, shown
from trajopt.model.reduced import ReducedModel
from trajopt.model.robot import Robot
from trajopt.nlp import Rows
from trajopt.terms.motion import Motion
from trajopt.terms.residual import Constraint, constraint

SHARE = 0.1
"""Share of the drift that is accepted which the program's own tolerances may add up to."""
DEFAULT_KNOTS = 24
"""Knots of a path; 20 to 32 make no difference, 16 lose a few problems."""
ROLLING_KNOTS = 48
"""The same where wheels roll: how far they stray falls with the square of a step; with 24 knots it is 10 to
30 mm on a journey of ten metres."""


MOST_KNOTS = 2000
"""Time and memory grow with the square of the knots: this many take some seconds and 0.3 GB."""


def stated_knots(robot: Robot, group: str, stated: int) -> int:
    """Return the number of knots of a path of a group: what a problem states, unless that is 0.

    Raises:
        ProblemError: If it is no whole number, too small or too large.
    """
    if stated != 0:
        whole = isinstance(stated, int)  # pyright: ignore[reportUnnecessaryIsInstance]
        if not whole or not 3 <= stated <= MOST_KNOTS:
            raise ProblemError(f"knots must be a whole number from 3 to {MOST_KNOTS}, not {shown(stated)}")
        return stated
    rolls = robot.base.rolling(robot.group(group).joints)
    return DEFAULT_KNOTS if rolls is None else ROLLING_KNOTS


@dataclass(frozen=True, eq=False)
class Rolling(Value):
    """How far each step from knot to knot goes across the heading in its middle [m].

    The chord of an arc of a circle is along the heading in its middle, so arcs and straight lines hold it
    exactly, and smooth curves but for the third power of the step.

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
    """Return the constraint that a base's wheels roll, where the group has such a base.

    Args:
        reduced: The model.
        knots: Number of knots of the motion.
    """
    base = reduced.scene.robot.base
    places = base.rolling(reduced.joint_names)
    if places is None:
        return ()
    return (constraint(Rolling(places), lower=0.0, upper=0.0, tolerance=SHARE * base.drift / knots),)
