"""An arm reaches for a thing on a shelf that it knows from the depths that two cameras measured, no more."""

from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, panda, pointing, ur5
from .drawing import drawn, near
from .furniture import WALL, Parts, shelf

SPACING = 0.34
"""Clear height of a storey [m]."""
DEPTH = 0.28
"""Depth of the shelf [m]."""
EYES = ((-0.3, 0.6, 1.0), (-0.3, -0.6, 0.7))
"""Where the cameras are: at both sides of the arm [m]."""
SLOPES = np.linspace(-0.7, 0.7, 120)
"""Slopes of a camera's rays, across and down."""
BETWEEN = 0.009
"""Half the diagonal of a pixel where the shelf is, a metre and a half away [m]."""
CELL = 0.02
"""Edge of the cubes of which each becomes one ball [m]."""


def unknown_shelf_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the Panda.

    What is hard: thousands of balls stand for boards and things, and the hand passes between them.

    Args:
        rng: Draws where the shelf and the things on it stand; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda()), rng)


def unknown_shelf_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: as for the Panda, without a joint to spare.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5()), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    distance, turn = near(rng, 0.95 * arm.reach + 0.06, 0.03), near(rng, 0.0, 0.2)
    stands = to.placement(rpy=(0.0, 0.0, turn)) * to.placement((distance, 0.0, 0.0))
    parts = shelf(width=0.8, depth=DEPTH, levels=3, spacing=SPACING)
    level = 1 if rng is None else int(rng.integers(0, 2))
    floor = WALL + level * (SPACING + WALL)
    across = near(rng, 0.08, 0.12)
    for side in (-1.0, 0.0, 1.0):
        height = near(rng, 0.14, 0.05)
        size = to.Box(0.06, near(rng, 0.06, 0.02), height)
        parts.append((size, to.placement((0.16, across + 0.22 * side, floor + height / 2))))
    cloud = to.Points(_measured([(box, stands * where) for box, where in parts]), BETWEEN).thinned(CELL)
    scene = to.Scene(arm.robot).add("camera", cloud)
    before = stands * np.array((-0.02, across, floor + SPACING / 2))
    direction = (float(np.cos(turn)), float(np.sin(turn)), 0.0)
    goal = pointing(arm, tuple(before.tolist()), direction, position_tolerance=0.01, cone=0.3)
    return to.Problem(scene=scene, group=arm.group, start=arm.ready, goal=goal, name="unknown shelf")


def _measured(parts: Parts) -> np.ndarray:
    """Return the points of boxes that cameras measure, shape (n, 3) in the world [m].

    Each ray ends at the first box that it meets: where it enters the last of the three pairs of faces.
    """
    found: list[np.ndarray] = []
    middle = np.mean([where.translation for _, where in parts], axis=0)
    for eye in np.array(EYES):
        rays = _rays(middle - eye)
        first = np.full(len(rays), np.inf)
        for box, where in parts:
            half = np.array((box.x, box.y, box.z)) / 2.0
            local = rays @ where.rotation
            begin = where.inverse() * eye
            with np.errstate(divide="ignore"):
                one, other = (-half - begin) / local, (half - begin) / local
            enters, leaves = np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)
            first = np.where((enters <= leaves) & (enters > 0.0), np.minimum(first, enters), first)
        met = np.isfinite(first)
        found.append(eye + rays[met] * first[met, None])
    return np.concatenate(found)


def _rays(forward: np.ndarray) -> np.ndarray:
    """Return the rays of a camera that looks along a direction, level, shape (n, 3)."""
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    across, down = (each.reshape(-1, 1) for each in np.meshgrid(SLOPES, SLOPES))
    return forward + across * right + down * np.cross(forward, right)
