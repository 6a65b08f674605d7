"""An arm reaches past a pillar."""

from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, panda, pointing, ur5, xarm7
from .drawing import drawn, near

DOWN = (0.0, 0.0, -1.0)


def past_pillar_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the Panda.

    What is hard: the straight line in joint space swings the hand through a pillar too high to lift
    it over; the arm must draw back or fold around it.

    Args:
        rng: Draws the pillar and how far the arm must swing; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda()), rng)


def past_pillar_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: as for the Panda, without a joint to spare.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5()), rng)


def past_pillar_xarm7(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the xArm7.

    What is hard: as for the Panda, with joints that turn further.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, xarm7()), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    away = arm.reach - near(rng, 0.03, 0.04)
    angle, size, height = near(rng, 0.0, 0.25), near(rng, 0.05, 0.02), near(rng, 0.8, 0.15)
    scene = (
        to.Scene(arm.robot)
        .add("table", to.Box(0.9, 1.6, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add(
            "pillar",
            to.Cylinder(size, height),
            to.placement((away * np.cos(angle), away * np.sin(angle), height / 2)),
        )
    )

    def side(angle: float) -> tuple[to.Requirement, to.Requirement]:
        point = (arm.reach * np.cos(angle), arm.reach * np.sin(angle), near(rng, 0.25, 0.08))
        return pointing(arm, point, DOWN)

    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, *side(-near(rng, 0.8, 0.15))),
        goal=side(near(rng, 0.8, 0.15)),
        name="past pillar",
    )
