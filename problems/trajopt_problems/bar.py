"""The hand grasps a bar wherever along it that is easiest."""

from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, panda, pointing, ur5, xarm7
from .drawing import drawn, near

LENGTH = 0.5
"""Of the part of the bar that may be grasped [m]."""


def bar_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the Panda.

    What is hard: the goal is a line and an angle, not a point, and a panel hides the part of the bar
    that is nearest.

    Args:
        rng: Draws bar and panel; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda()), rng)


def bar_xarm7(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the xArm7.

    What is hard: as for the Panda, without fingers.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, xarm7()), rng)


def bar_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: as for the Panda, without fingers and without a joint to spare.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5()), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    lies = to.placement(
        (near(rng, arm.reach, 0.05), near(rng, 0.1, 0.1), near(rng, 0.3, 0.08)),
        rpy=(np.pi / 2, 0.0, near(rng, 0.0, 0.4)),
    )
    panel_at = to.placement((-0.15, 0.05, near(rng, 0.2, 0.05)))
    scene = (
        to.Scene(arm.robot)
        .add("bar", to.Cylinder(0.01, LENGTH + 0.1), lies)
        .add("panel", to.Box(0.02, 0.5, 0.5), panel_at, frame="bar")
    )
    along = to.frame_placement(
        arm.tip,
        to.placement((0.0, 0.06, 0.0)),
        reference="bar",
        position_tolerance=(5e-3, 5e-3, LENGTH / 2),
        rotation_tolerance=np.inf,
    )
    over = to.axis_alignment(arm.tip, direction=(0.0, -1.0, 0.0), reference="bar", tolerance=0.3)
    beside = pointing(arm, (0.25, -0.4, 0.5), (0.0, 0.0, -1.0), cone=0.3)
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, *beside),
        goal=(along, over),
        name="along a bar",
    )
