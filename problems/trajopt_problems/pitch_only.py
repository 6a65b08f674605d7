"""A jug is tipped about its handle and about nothing else."""

import numpy as np

import trajopt as to

from .arms import panda
from .drawing import drawn, near

ROLL = np.radians(4.0)
"""Largest roll and yaw of the jug [rad]."""


def pitch_only(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem: a Panda brings a jug past a bottle and tips it by two thirds of a right angle.

    What is hard: of the three Euler angles one is free and two are held all the way, while the jug
    moves half a metre and its place is free.

    Args:
        rng: Draws the bottle, the start and where and how far the jug is tipped; the fixed instance
            when None.

    Expected outcome: solved.
    """
    return drawn(_problem, rng)


def _problem(rng: np.random.Generator | None) -> to.Problem:
    arm = panda()
    scene = (
        to.Scene(arm.robot)
        .add("table", to.Box(0.9, 1.6, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add(
            "bottle", to.Cylinder(0.04, 0.5), to.placement((near(rng, 0.52, 0.04), near(rng, 0.0, 0.1), 0.25))
        )
        .add(
            "jug",
            to.Cylinder(0.05, 0.16),
            to.placement((0.0, 0.0, 0.05), rpy=(np.pi, 0.0, 0.0)),
            frame=arm.tip,
            touch_links=arm.hand,
        )
    )
    roll_and_yaw = to.frame_placement(
        "jug",
        to.placement(),
        position_tolerance=np.inf,
        rotation_tolerance=(ROLL, np.inf, ROLL),
        coordinates=to.RotationCoordinates.XYZ_EULER,
    )

    def tipped(y: float, pitch: float) -> to.Requirement:
        point = (near(rng, 0.45, 0.05), y, near(rng, 0.25, 0.05))
        return to.frame_placement(
            "jug",
            to.placement(point, rpy=(0.0, pitch, 0.0)),
            position_tolerance=2e-3,
            rotation_tolerance=(ROLL, 0.02, ROLL),
            coordinates=to.RotationCoordinates.XYZ_EULER,
        )

    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, tipped(near(rng, -0.3, 0.05), 0.0), roll_and_yaw),
        goal=tipped(near(rng, 0.3, 0.05), near(rng, 1.0, 0.2)),
        constraints=[roll_and_yaw],
        name="pitch only",
    )
