"""A hand turns over under a low ceiling and ducks below a beam."""

from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, panda, pointing, ur5, xarm7
from .drawing import drawn, near


def turn_over_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the Panda.

    What is hard: from pointing down to pointing sideways and up, between a ceiling and a table where
    the wrist has no room to swing high; a beam hangs from the ceiling across the way.

    Args:
        rng: Draws ceiling, start and goal; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda()), rng)


def turn_over_xarm7(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the xArm7.

    What is hard: as for the Panda, with joints that turn further.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, xarm7()), rng)


def turn_over_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: as for the Panda, without a joint to spare.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5()), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    ceiling = to.placement((0.65, 0.0, near(rng, 0.75, 0.05)))
    scene = (
        to.Scene(arm.robot)
        .add("table", to.Box(0.9, 1.6, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add("ceiling", to.Box(0.9, 1.6, 0.04), ceiling)
        .add("beam", to.Box(0.7, 0.03, 0.4), to.placement((0.0, 0.05, -0.2)), frame="ceiling")
    )
    azimuth = near(rng, 0.8, 0.2)
    point = (0.42 * np.cos(azimuth), 0.42 * np.sin(azimuth), near(rng, 0.42, 0.06))
    lift = near(rng, 0.4, 0.3)
    ahead, up = float(np.cos(lift)), float(np.sin(lift))
    direction = (ahead * float(np.cos(azimuth)), ahead * float(np.sin(azimuth)), up)
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, *pointing(arm, (0.42, near(rng, -0.3, 0.1), 0.15), (0.0, 0.0, -1.0), cone=0.2)),
        goal=pointing(arm, point, direction, cone=0.15),
        name="turn over",
    )
