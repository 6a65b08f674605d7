"""A camera at the hand keeps a part in view while the hand moves around it."""

from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, panda, pointing, ur5
from .drawing import drawn, near

DISTANCE = 0.3
"""Of the part from the camera [m]."""


def keep_in_view_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the Panda.

    What is hard: the part stays in a box before the camera, three centimetres to each side and
    five in depth: position and direction of the hand are bound to each other all the way.

    Args:
        rng: Draws the part and from where it is seen; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda()), rng)


def keep_in_view_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: as for the Panda, without a joint to spare.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5()), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    part = np.array((near(rng, arm.reach, 0.04), near(rng, 0.0, 0.1), near(rng, 0.08, 0.04)))
    scene = (
        to.Scene(arm.robot)
        .add("table", to.Box(0.9, 1.8, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add("part", to.Box(0.06, 0.06, 0.06), to.placement(part))
        .add("camera", [], frame=arm.tip)
    )

    def seen_from(azimuth: float) -> tuple[to.Requirement, to.Requirement]:
        lean = near(rng, 0.75, 0.1)
        away = np.array((np.sin(lean) * np.cos(azimuth), np.sin(lean) * np.sin(azimuth), np.cos(lean)))
        point = tuple((part + DISTANCE * away).tolist())
        return pointing(arm, point, tuple((-away).tolist()), cone=0.05, position_tolerance=0.01)

    in_view = to.frame_placement(
        "part",
        to.placement((0.0, 0.0, DISTANCE)),
        reference="camera",
        position_tolerance=(0.03, 0.03, 0.05),
        rotation_tolerance=np.inf,
    )
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, *seen_from(near(rng, -1.9, 0.3)), in_view),
        goal=seen_from(near(rng, 1.9, 0.3)),
        constraints=[in_view],
        name="keep in view",
    )
