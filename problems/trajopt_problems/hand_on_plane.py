"""The hand keeps its height above a plane, as in wiping: at no particular speed, along no particular line."""

from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, panda, ur5
from .drawing import drawn, near

HEIGHT = 0.05
"""Of the tool above the table [m]."""


def hand_on_plane_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the Panda.

    What is hard: the tool stays within two millimetres of a plane and within three degrees of its
    normal, and things that stand on the table have to be gone around, not lifted over.

    Args:
        rng: Draws what stands there, start and goal; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda()), rng)


def hand_on_plane_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: the plane leaves it three joints of six.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5()), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    away, at = arm.reach - near(rng, 0.02, 0.04), near(rng, 0.0, 0.15)
    scene = (
        to.Scene(arm.robot)
        .add("table", to.Box(0.9, 1.8, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add("can", to.Cylinder(0.04, 0.12), to.placement((away * np.cos(at), away * np.sin(at), 0.06)))
    )

    def place(angle: float) -> to.Requirement:
        point = (arm.reach * np.cos(angle), arm.reach * np.sin(angle), HEIGHT)
        return to.frame_placement(
            arm.tip,
            to.placement(point),
            position_tolerance=(5e-3, 5e-3, np.inf),
            rotation_tolerance=np.inf,
        )

    on_plane = (
        to.frame_placement(
            arm.tip,
            to.placement((0.0, 0.0, HEIGHT)),
            position_tolerance=(np.inf, np.inf, 2e-3),
            rotation_tolerance=np.inf,
        ),
        to.axis_alignment(arm.tip, direction=(0.0, 0.0, -1.0), tolerance=np.radians(3.0)),
    )
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, place(near(rng, -0.6, 0.15)), *on_plane),
        goal=place(near(rng, 0.6, 0.15)),
        constraints=on_plane,
        name="hand on plane",
    )
