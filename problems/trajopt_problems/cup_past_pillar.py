"""A Panda carries an upright cup past a pillar that stands on a table."""

from functools import partial

import numpy as np

import trajopt as to

from .drawing import drawn, near

START = {
    "panda_joint1": -0.6,
    "panda_joint2": 0.0086,
    "panda_joint3": 0.0,
    "panda_joint4": -2.3619,
    "panda_joint5": 0.0,
    "panda_joint6": 2.3705,
    "panda_joint7": 0.7854,
    "panda_finger_joint1": 0.035,
    "panda_finger_joint2": 0.035,
}
"""The hand points down over the right half of the table, its fingers around the cup's rim [rad | m]."""


def problem(tilt: float = np.radians(5.0), rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem: carry the cup past the pillar without tilting it.

    What is hard: the straight line in joint space runs through the pillar, which is too high to lift
    the cup over; the way behind it needs all joints at once, and the cup must stay upright.

    Args:
        tilt: Largest angle between the cup's axis and the vertical [rad].
        rng: Draws where the pillar stands, how thick it is and where the cup goes; the fixed instance
            when None.

    Expected outcome: solved from the straight line.
    """
    return drawn(partial(_problem, tilt), rng)


def _problem(tilt: float, rng: np.random.Generator | None) -> to.Problem:
    panda = to.load("panda")
    scene = (
        to.Scene(panda)
        .add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add(
            "pillar",
            to.Cylinder(near(rng, 0.05, 0.02), 0.8),
            to.placement((near(rng, 0.55, 0.05), near(rng, 0.0, 0.08), 0.4)),
        )
        .add(
            "cup",
            to.Cylinder(0.034, 0.12),
            to.placement((0.0, 0.0, 0.04), rpy=(np.pi, 0.0, 0.0)),
            frame="panda_hand_tcp",
            touch_links=("panda_hand", "panda_leftfinger", "panda_rightfinger"),
        )
    )
    return to.Problem(
        scene=scene,
        group="panda_arm",
        start=START,
        goal=to.frame_placement(
            "cup",
            to.placement((near(rng, 0.41, 0.1), near(rng, 0.30, 0.05), near(rng, 0.14, 0.04))),
            position_tolerance=1e-3,
            rotation_tolerance=(tilt, tilt, np.inf),
        ),
        constraints=[to.axis_alignment("cup", tolerance=tilt)],
        name="cup past pillar",
    )
