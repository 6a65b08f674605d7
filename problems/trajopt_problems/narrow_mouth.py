"""An arm reaches into a box through a narrow mouth."""

from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, panda, pointing, ur5, with_rod, xarm7
from .drawing import drawn, near
from .furniture import hollow_box


def narrow_mouth_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the Panda.

    What is hard: hand and wrist pass the mouth with about three centimetres to spare, turned along
    its long side, and what enters must stay aligned while it goes down.

    Args:
        rng: Draws the box, its mouth and the depth; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda()), rng)


def narrow_mouth_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: a rod in its flange enters, and no joint is to spare.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5()), rng)


def narrow_mouth_xarm7(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the xArm7.

    What is hard: as for the Panda, with a rod in its flange.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, xarm7()), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    height, depth = near(rng, 0.3, 0.03), near(rng, 0.14, 0.02)
    mouth = (near(rng, 0.13, 0.01), arm.width + near(rng, 0.07, 0.01))
    at = near(rng, -0.45, 0.3)
    away = near(rng, arm.reach, 0.04)
    stands = to.placement(rpy=(0.0, 0.0, at)) * to.placement(
        (away, 0.0, height / 2), rpy=(0.0, 0.0, near(rng, 0.5, 0.4))
    )
    scene = (
        to.Scene(arm.robot)
        .add("table", to.Box(1.0, 1.6, 0.04), to.placement((0.7, 0.0, -0.05)))
        .add("box", hollow_box((0.3, 0.4, height), mouth=mouth), stands)
    )
    frame = arm.tip
    if arm is not panda():
        scene, frame = with_rod(arm, scene), "rod_tip"
    aside = pointing(arm, (0.35, 0.3, 0.5), (0.0, 0.0, -1.0), cone=0.5, frame=frame)
    inside = stands * np.array((0.0, 0.0, height / 2 - depth))
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, *aside),
        goal=pointing(
            arm,
            tuple(inside.tolist()),
            (0.0, 0.0, -1.0),
            cone=0.2,
            position_tolerance=0.01,
            frame=frame,
        ),
        name="narrow mouth",
    )
