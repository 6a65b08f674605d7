"""An arm reaches under a table."""

from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, panda, pointing, ur5, xarm7
from .drawing import drawn, near
from .furniture import table


def under_table_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the Panda.

    What is hard: the hand starts above the table and ends below its top, so it has to draw back
    around the edge between two legs; the straight line goes through the top.

    Args:
        rng: Draws table, start and goal; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda()), rng)


def under_table_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: as for the Panda, without a joint to spare.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5()), rng)


def under_table_xarm7(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the xArm7.

    What is hard: as for the Panda, with joints that turn further.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, xarm7()), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    height = near(rng, 0.45, 0.05)
    stands = to.placement((near(rng, arm.reach + 0.2, 0.04), near(rng, 0.0, 0.1), -0.1))
    scene = to.Scene(arm.robot).add("table", table(length=0.6, width=1.1, height=height + 0.1), stands)
    above = (near(rng, arm.reach, 0.05), near(rng, -0.15, 0.1), height + near(rng, 0.15, 0.05))
    below = (near(rng, arm.reach, 0.05), near(rng, 0.1, 0.15), near(rng, 0.2, 0.06))
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, *pointing(arm, above, (0.0, 0.0, -1.0), cone=0.3)),
        goal=pointing(arm, below, (1.0, 0.0, 0.0), cone=0.4),
        name="under table",
    )
