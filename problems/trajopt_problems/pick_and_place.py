"""A block is lifted from a table and set down on a stand: it touches both, at the ends only."""

from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, panda, ur5
from .drawing import drawn, near

SIZE = 0.06
"""Edge of the block [m]."""


def pick_and_place_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the Panda.

    What is hard: the block begins and ends in contact, which is meant for the first and last half
    second and for nothing else; a wall stands between table and stand.

    Args:
        rng: Draws wall, stand and where the block is; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda()), rng)


def pick_and_place_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: as for the Panda, with the block held by suction.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5()), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    wall, stand = near(rng, 0.3, 0.05), near(rng, 0.12, 0.05)
    stands_at = np.array((near(rng, arm.reach - 0.05, 0.05), near(rng, 0.35, 0.04), 0.0))
    picked_at = np.array((near(rng, arm.reach - 0.05, 0.05), near(rng, -0.3, 0.05), 0.0))
    scene = (
        to.Scene(arm.robot)
        .add("table", to.Box(0.9, 1.6, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add("wall", to.Box(0.5, 0.03, wall), to.placement((arm.reach, 0.0, wall / 2)))
        .add("stand", to.Box(0.16, 0.16, stand), to.placement(stands_at + np.array((0.0, 0.0, stand / 2))))
        .add(
            "block",
            to.Box(SIZE, SIZE, SIZE),
            to.placement((0.0, 0.0, SIZE / 2)),
            frame=arm.tip,
            touch_links=arm.hand,
        )
        .allow_contact("lifting", "block", "table", first=0.5)
        .allow_contact("setting down", "block", "stand", last=0.5)
    )

    def lies_on(point: np.ndarray) -> tuple[to.Requirement, to.Requirement]:
        return (
            to.frame_placement(
                "block",
                to.placement(point + np.array((0.0, 0.0, SIZE / 2))),
                position_tolerance=(2e-3, 2e-3, 2e-4),
                rotation_tolerance=np.inf,
            ),
            to.axis_alignment("block", direction=(0.0, 0.0, -1.0), tolerance=2e-3),
        )

    lifted = scene.allow("block", "table")
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(lifted, *lies_on(picked_at)),
        goal=lies_on(stands_at + np.array((0.0, 0.0, stand))),
        name="pick and place",
    )
