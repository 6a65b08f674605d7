"""An arm carries a tray that stays level but is free to spin."""

from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, pointing, ur5, xarm7
from .drawing import drawn, near


def level_tray_xarm7(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the xArm7.

    What is hard: the tray sticks out on all sides and must be turned and drawn back past a post while
    it tilts by less than three degrees.

    Args:
        rng: Draws post, start and goal; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, xarm7()), rng)


def level_tray_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: level leaves it four joints of six.

    Args:
        rng: As for the xArm7; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5()), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    away, at = arm.reach - near(rng, 0.02, 0.04), near(rng, 0.0, 0.15)
    scene = (
        to.Scene(arm.robot)
        .add("table", to.Box(0.9, 1.8, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add("post", to.Cylinder(0.03, 0.9), to.placement((away * np.cos(at), away * np.sin(at), 0.45)))
        .add(
            "tray",
            to.Box(0.24, 0.16, 0.02),
            to.placement((0.0, 0.0, 0.011)),
            frame=arm.tip,
            touch_links=arm.hand,
        )
    )
    down = (0.0, 0.0, -1.0)

    def place(angle: float) -> to.Requirement:
        point = (arm.reach * np.cos(angle), arm.reach * np.sin(angle), near(rng, 0.3, 0.1))
        return pointing(arm, point, down)[0]

    level = to.axis_alignment(arm.tip, direction=down, tolerance=np.radians(3.0))
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, place(near(rng, -0.9, 0.15)), level),
        goal=place(near(rng, 0.9, 0.15)),
        constraints=[level],
        name="level tray",
    )
