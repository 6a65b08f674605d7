"""A narrow passage between two plates."""

from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, panda, pointing, ur5, with_rod, xarm7
from .drawing import drawn, near


def between_plates_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the Panda.

    What is hard: the hand is wider than the passage unless it is turned edgewise, and the plates are
    too large to go around.

    Args:
        rng: Draws the plates and the point between them; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda()), rng)


def between_plates_xarm7(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the xArm7.

    What is hard: its wrist enters the passage with little to spare.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, xarm7()), rng)


def between_plates_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: a rod in its flange enters, and no joint is to spare.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5()), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    gap, height = near(rng, 0.15, 0.01), near(rng, 0.35, 0.05)
    at = near(rng, -0.5, 0.4)
    stands = to.placement(rpy=(0.0, 0.0, at)) * to.placement(
        (near(rng, arm.reach, 0.04), 0.0, 0.0), rpy=(0.0, 0.0, near(rng, 0.3, 0.3))
    )
    plates = [
        (to.Box(0.5, 0.02, height), to.placement((0.0, side * (gap / 2 + 0.01), height / 2)))
        for side in (-1, 1)
    ]
    scene = to.Scene(arm.robot).add("plates", plates, stands)
    frame = arm.tip
    if arm is ur5():
        scene, frame = with_rod(arm, scene), "rod_tip"
    inside = stands * np.array((0.0, 0.0, height - near(rng, 0.1, 0.03)))
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.ready,
        goal=pointing(
            arm,
            tuple(inside.tolist()),
            (0.0, 0.0, -1.0),
            cone=0.3,
            position_tolerance=0.01,
            frame=frame,
        ),
        name="between plates",
    )
