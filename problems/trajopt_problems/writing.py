"""Figures written with the tool down: circle, figure-eight and a letter, through their points in order."""

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

import trajopt as to

from .arms import Arm, panda, ur5, xarm7
from .drawing import drawn, near

Figure = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Shares of the way, shape (s,), to points of a figure of size one, shape (s, 2)."""

POINTS = 24
"""Of a figure, its end among them."""
KNOTS = 49
"""Two between any two points."""
TOLERANCE = 3e-3
"""How near a point is passed [m]."""
HEIGHT = 0.1
"""Of the pen above the base [m]."""


def circle_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem of a circle for the Panda.

    What is hard: 24 points in order, on a plane within two millimetres, the tool upright within five
    degrees all the way.

    Args:
        rng: Draws place, size and turn of the figure; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda(), _circle), rng)


def circle_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem of a circle for the UR5.

    What is hard: as for the Panda, without a joint to spare.

    Args:
        rng: As for the Panda.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5(), _circle), rng)


def figure_eight_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem of a figure-eight for the Panda.

    What is hard: the way crosses itself, so that the order of the points matters.

    Args:
        rng: As for the circle.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda(), _eight), rng)


def figure_eight_xarm7(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem of a figure-eight for the xArm7.

    What is hard: as for the Panda.

    Args:
        rng: As for the circle.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, xarm7(), _eight), rng)


def letter_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem of a letter M for the Panda.

    What is hard: the way turns sharply at its corners, which no smooth motion does at speed.

    Args:
        rng: As for the circle.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda(), _letter), rng)


def letter_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem of a letter M for the UR5.

    What is hard: as for the Panda, without a joint to spare.

    Args:
        rng: As for the circle.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5(), _letter), rng)


def _circle(share: NDArray[np.float64]) -> NDArray[np.float64]:
    angle = 2.0 * np.pi * share
    return 0.5 * np.stack((np.cos(angle), np.sin(angle)), axis=1)


def _eight(share: NDArray[np.float64]) -> NDArray[np.float64]:
    angle = 2.0 * np.pi * share
    return 0.5 * np.stack((0.5 * np.sin(2.0 * angle), np.sin(angle)), axis=1)


def _letter(share: NDArray[np.float64]) -> NDArray[np.float64]:
    corners = np.array(((-0.5, -0.5), (-0.5, 0.5), (0.0, 0.0), (0.5, 0.5), (0.5, -0.5)))
    at = np.linspace(0.0, 1.0, len(corners))
    return np.stack([np.interp(share, at, corners[:, axis]) for axis in (0, 1)], axis=1)


def _problem(arm: Arm, figure: Figure, rng: np.random.Generator | None) -> to.Problem:
    size, turn = near(rng, 0.18, 0.04), near(rng, 0.0, 0.5)
    centre = np.array((arm.reach - 0.05 + near(rng, 0.0, 0.03), near(rng, 0.0, 0.1), HEIGHT))
    cos, sin = np.cos(turn), np.sin(turn)
    flat = size * figure(np.linspace(0.0, 1.0, POINTS + 1)) @ np.array(((cos, sin), (-sin, cos)))
    points = centre + np.column_stack((flat, np.zeros(len(flat))))

    pen = (
        to.axis_alignment(arm.tip, direction=(0.0, 0.0, -1.0), tolerance=np.radians(5.0)),
        to.point_on_plane(arm.tip, (0.0, 0.0, HEIGHT), (0.0, 0.0, 1.0), tolerance=2e-3),
    )
    scene = to.Scene(arm.robot).add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
    first, *between, last = (arm.tip_at(point, TOLERANCE) for point in points)
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, first, *pen),
        goal=last,
        waypoints=between,
        constraints=pen,
        knots=KNOTS,
        name="writing",
    )
