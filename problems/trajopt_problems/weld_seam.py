"""A torch follows a seam: through its points in order, tilted within a cone, free to spin about itself."""

from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, panda, ur5
from .drawing import drawn
from .stroke import stroke

POINTS = 16
"""Of the seam, its end among them."""
KNOTS = 33
"""Two between any two points."""
TOLERANCE = 2e-3
"""How near a point of the seam is passed [m]."""


def weld_seam_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the Panda.

    What is hard: the tip stays within two millimetres of the seam all the way and the torch leans by at
    most 15 degrees, beside a plate that stands along the seam; only the spin is free.

    Args:
        rng: Draws where the seam lies and how it runs; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda()), rng)


def weld_seam_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: as for the Panda, with the spin as the one freedom of six joints.

    Args:
        rng: As for the Panda.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5()), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    seam = stroke(arm, rng, length=0.3, turn=0.2, height=0.15, points=POINTS)
    beside = to.placement(seam.middle + 0.16 * seam.across, rpy=(0.0, 0.0, np.arctan2(*seam.across[1::-1])))
    scene = (
        to.Scene(arm.robot)
        .add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add("plate", to.Box(0.01, seam.length, 0.1), beside)
    )
    torch = (
        to.axis_alignment(arm.tip, direction=(0.0, 0.0, -1.0), tolerance=np.radians(15.0)),
        to.point_on_line(arm.tip, seam.middle, seam.along, tolerance=TOLERANCE),
    )
    first, *between, last = (arm.tip_at(point, TOLERANCE) for point in seam.points)
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, first, *torch),
        goal=last,
        waypoints=between,
        constraints=torch,
        knots=KNOTS,
        tool_speed=to.tool_speed(arm.tip, linear=0.1),
        name="weld seam",
    )
