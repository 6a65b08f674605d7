"""An arm carries an upright cup through the gap between two posts."""

from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, panda, ur5, xarm7
from .drawing import drawn, near

TILT = np.radians(5.0)
"""Largest angle between the cup's axis and the vertical [rad]."""


def cup_through_gap_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the Panda.

    What is hard: one post is too high to pass over, the other stands between the gap and the base, so
    the forearm crosses above it while the hand turns edgewise to fit between; the cup stays upright.

    Args:
        rng: Draws posts, start and goal; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda()), rng)


def cup_through_gap_xarm7(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the xArm7.

    What is hard: as for the Panda, with the cup under its flange.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, xarm7()), rng)


def cup_through_gap_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: as for the Panda, without a joint to spare.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5()), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    gap, at = near(rng, 0.15, 0.01), near(rng, 0.0, 0.15)
    middle = arm.reach - near(rng, 0.12, 0.03)
    low, high = near(rng, 0.28, 0.03), 0.9
    inner, outer = middle - gap / 2 - 0.03, middle + gap / 2 + 0.03
    turned = to.placement(rpy=(0.0, 0.0, at))
    scene = (
        to.Scene(arm.robot)
        .add("table", to.Box(0.9, 1.6, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add("inner_post", to.Cylinder(0.03, low), turned * to.placement((inner, 0.0, low / 2)))
        .add("outer_post", to.Cylinder(0.03, high), turned * to.placement((outer, 0.0, high / 2)))
        .add(
            "cup",
            to.Cylinder(0.034, 0.12),
            to.placement((0.0, 0.0, 0.06), rpy=(np.pi, 0.0, 0.0)),
            frame=arm.tip,
            touch_links=arm.hand,
        )
    )

    def place(angle: float) -> to.Requirement:
        away = near(rng, arm.reach + 0.04, 0.03)
        point = (away * np.cos(angle), away * np.sin(angle), near(rng, 0.14, 0.03))
        return to.frame_placement(
            "cup", to.placement(point), position_tolerance=2e-3, rotation_tolerance=np.inf
        )

    upright = to.axis_alignment("cup", tolerance=TILT)
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, place(near(rng, -0.7, 0.15)), upright),
        goal=place(near(rng, 0.7, 0.15)),
        constraints=[upright],
        name="cup through gap",
    )
