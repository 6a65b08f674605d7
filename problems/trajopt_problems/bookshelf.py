"""An arm reaches between the books of a shelf."""

from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, panda, pointing, ur5, xarm7
from .drawing import drawn, near
from .furniture import WALL, shelf

SPACING = 0.3
"""Clear height of a storey [m]."""
DEPTH = 0.28
"""Depth of the shelf [m]."""


def bookshelf_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the Panda.

    What is hard: from a storey the arm must leave straight backwards, pass the boards and enter
    another storey between two books, where hand and forearm fit in few configurations.

    Args:
        rng: Draws where the shelf stands, the storeys and the gaps; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda()), rng)


def bookshelf_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: as for the Panda, without a joint to spare.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5()), rng)


def bookshelf_xarm7(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the xArm7.

    What is hard: as for the Panda, with joints that turn further.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, xarm7()), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    distance, turn = near(rng, 0.9 * arm.reach, 0.04), near(rng, 0.0, 0.3)
    stands = to.placement(rpy=(0.0, 0.0, turn)) * to.placement((distance, 0.0, near(rng, 0.0, 0.05)))
    scene = to.Scene(arm.robot).add("shelf", shelf(width=0.8, depth=DEPTH, levels=3, spacing=SPACING), stands)
    first, second = (1, 0) if rng is None else rng.choice(3, 2, replace=False).tolist()
    goals: list[tuple[to.Requirement, to.Requirement]] = []
    for name, level, side in (("from", first, -1.0), ("to", second, 1.0)):
        floor = WALL + level * (SPACING + WALL)
        y, gap = side * near(rng, 0.15, 0.1), arm.width + near(rng, 0.14, 0.03)
        for count, way in enumerate((-1.0, 1.0)):
            height = near(rng, 0.22, 0.04)
            at = to.placement((DEPTH - 0.1, y + way * (gap / 2 + 0.02), floor + height / 2 + 0.001))
            scene = scene.add(f"{name}_book{count}", to.Box(0.16, 0.04, height), at, frame="shelf")
        middle = stands * np.array((0.06, y, floor + SPACING / 2))
        direction = (float(np.cos(turn)), float(np.sin(turn)), 0.0)
        goals.append(pointing(arm, tuple(middle.tolist()), direction, position_tolerance=5e-3, cone=0.3))
    return to.Problem(
        scene=scene, group=arm.group, start=arm.at(scene, *goals[0]), goal=goals[1], name="bookshelf"
    )
