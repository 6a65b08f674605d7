"""A plane is wiped in strokes at constant speed, the tool on the plane and upright."""

from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, panda, ur5
from .drawing import drawn
from .stroke import stroke

POINTS = 6
"""Of a stroke, its end among them."""
KNOTS = 25
"""Four between any two points."""
TOLERANCE = 2e-3
"""How near a point of the stroke is passed [m]."""
SPEED, STEADY = 0.08, 0.1
"""Of the tool [m/s], and the share by which it may be slower between its ramps."""


def wiping_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the Panda.

    What is hard: a straight stroke within two millimetres, on the plane within one, at a speed that stays
    the same within a tenth from the first ramp to the last.

    Args:
        rng: Draws where the stroke lies and how it runs; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda()), rng)


def wiping_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: as for the Panda.

    Args:
        rng: As for the Panda.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5()), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    swipe = stroke(arm, rng, length=0.4, turn=0.1, height=0.12, points=POINTS)
    cloth = (
        to.axis_alignment(arm.tip, direction=(0.0, 0.0, -1.0), tolerance=np.radians(5.0)),
        to.point_on_line(arm.tip, swipe.middle, swipe.along, tolerance=TOLERANCE),
        to.point_on_plane(arm.tip, swipe.middle, (0.0, 0.0, 1.0), tolerance=TOLERANCE / 2),
    )
    scene = to.Scene(arm.robot).add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
    first, *between, last = (arm.tip_at(point, TOLERANCE) for point in swipe.points)
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, first, *cloth),
        goal=last,
        waypoints=between,
        constraints=cloth,
        knots=KNOTS,
        tool_speed=to.tool_speed(arm.tip, linear=SPEED, steady=STEADY),
        name="wiping",
    )
