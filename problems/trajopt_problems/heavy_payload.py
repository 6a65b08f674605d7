"""A load near what the joints can hold, carried with the arm stretched out."""

from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, panda, ur5
from .drawing import drawn, near


def heavy_payload_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the Panda.

    What is hard: the load asks for nine tenths of what a wrist joint can hold, in some postures for
    more: those have to be kept away from, and what is left of the torque sets the pace.

    Args:
        rng: Draws the load, start and goal; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda(), 5.5), rng)


def heavy_payload_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: as for the Panda.

    Args:
        rng: As for the Panda.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5(), 10.0), rng)


def _problem(arm: Arm, load: float, rng: np.random.Generator | None) -> to.Problem:
    scene = (
        to.Scene(arm.robot)
        .add("table", to.Box(0.9, 1.8, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add("post", to.Cylinder(0.04, 0.5), to.placement((arm.reach + 0.05, 0.0, 0.25)))
        .add(
            "load",
            to.Cylinder(0.04, 0.1),
            to.placement((0.0, 0.0, 0.06)),
            frame=arm.tip,
            touch_links=arm.hand,
            mass=near(rng, load, 0.1 * load),
        )
    )

    def beside(angle: float) -> to.Requirement:
        point = (arm.reach * np.cos(angle), arm.reach * np.sin(angle), near(rng, 0.3, 0.05))
        return to.frame_placement(
            arm.tip, to.placement(point), position_tolerance=5e-3, rotation_tolerance=np.inf
        )

    held = to.gravity_torque(share=0.9)
    down = to.axis_alignment(arm.tip, direction=(0.0, 0.0, -1.0), tolerance=np.radians(20.0))
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, beside(near(rng, -0.7, 0.1)), down, held),
        goal=[beside(near(rng, 0.7, 0.1)), down],
        constraints=[held],
        name="heavy payload",
    )
