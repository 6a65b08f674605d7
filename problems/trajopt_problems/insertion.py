"""A peg slides into a hole along its axis."""

from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, panda, ur5, xarm7
from .drawing import drawn, near
from .furniture import hollow_box

PEG = 0.1
"""Length of the peg [m]."""
ASIDE = 1e-3
"""How far the peg may leave its axis [m]."""


def insertion_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the Panda.

    What is hard: the peg has three millimetres around it and stays within one of its axis, straight
    within half a degree, all the way: a line constraint, held between the knots too.

    Args:
        rng: Draws where the hole is and how it leans; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda()), rng)


def insertion_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: six joints, the line fixes five of them.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5()), rng)


def insertion_xarm7(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the xArm7.

    What is hard: as for the Panda, with joints that turn further.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, xarm7()), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    at = near(rng, 0.4, 0.6)
    away = near(rng, arm.reach - 0.05, 0.06)
    lean = (near(rng, 0.0, 0.15), near(rng, 0.1, 0.15), near(rng, 0.0, 0.5))
    hole = to.placement((away * np.cos(at), away * np.sin(at), near(rng, 0.2, 0.05)), rpy=lean)
    scene = (
        to.Scene(arm.robot)
        .add("block", hollow_box((0.036, 0.036, 0.09), open_sides=("+z",)), hole)
        .add("mouth", [], to.placement((0.0, 0.0, 0.045), rpy=(np.pi, 0.0, 0.0)), frame="block")
        .add(
            "peg",
            to.Cylinder(0.015, PEG),
            to.placement((0.0, 0.0, PEG / 2)),
            frame=arm.tip,
            touch_links=arm.hand,
        )
        .add("peg_end", [], to.placement((0.0, 0.0, PEG)), frame=arm.tip)
        .with_margin(1e-3, "peg", "block")
    )

    def depth(inside: float) -> to.Requirement:
        return to.frame_placement(
            "peg_end",
            to.placement((0.0, 0.0, inside)),
            reference="mouth",
            position_tolerance=5e-4,
            rotation_tolerance=(5e-3, 5e-3, np.inf),
        )

    line = to.frame_placement(
        "peg_end",
        to.placement(),
        reference="mouth",
        position_tolerance=(ASIDE, ASIDE, np.inf),
        rotation_tolerance=(0.01, 0.01, np.inf),
    )
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, depth(-0.06)),
        goal=depth(0.06),
        constraints=[line],
        name="insertion",
    )
