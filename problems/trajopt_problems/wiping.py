"""A plane is wiped in strokes at constant speed, the tool on the plane and upright."""

import numpy as np

import trajopt as to

from .arms import Arm, panda, ur5
from .drawing import near, until_feasible

POINTS = 8
"""Of a stroke, its end among them."""
KNOTS = 33
"""Four between any two points."""
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
    return _draw(panda(), rng)


def wiping_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: as for the Panda.

    Args:
        rng: As for the Panda.

    Expected outcome: solved.
    """
    return _draw(ur5(), rng)


def _draw(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    return _problem(arm, None) if rng is None else until_feasible(lambda: _problem(arm, rng), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    length, turn, height = near(rng, 0.4, 0.05), near(rng, 0.1, 0.2), near(rng, 0.12, 0.02)
    along = np.array((-np.sin(turn), np.cos(turn), 0.0))
    middle = np.array((arm.reach - 0.05, near(rng, 0.0, 0.05), height))
    points = middle + np.linspace(-0.5, 0.5, POINTS + 1)[:, None] * length * along

    def at(point: np.ndarray) -> to.Requirement:
        return to.frame_placement(
            arm.tip, to.placement(point), position_tolerance=2e-3, rotation_tolerance=np.inf
        )

    cloth = (
        to.axis_alignment(arm.tip, direction=(0.0, 0.0, -1.0), tolerance=np.radians(5.0)),
        to.point_on_line(arm.tip, middle, along, tolerance=2e-3),
        to.point_on_plane(arm.tip, middle, (0.0, 0.0, 1.0), tolerance=1e-3),
    )
    scene = to.Scene(arm.robot).add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, at(points[0]), *cloth),
        goal=at(points[-1]),
        waypoints=[at(point) for point in points[1:-1]],
        constraints=cloth,
        knots=KNOTS,
        tool_speed=to.tool_speed(arm.tip, linear=SPEED, steady=STEADY),
        name="wiping",
    )
