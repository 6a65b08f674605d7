"""A block is lifted from a table and set down on a stand or in a vice: it touches them at the ends only."""

from collections.abc import Mapping
from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, panda, ur5
from .drawing import drawn, near

SIZE = 0.06
"""Edge of the block [m]."""
BED = 0.1
"""Height of the machine's bed [m]."""
GAP = 0.005
"""Room between the block and each jaw of the vice [m]."""


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


def machine_tending_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the Panda.

    What is hard: the block passes home, the door of a machine and the jaws of a vice in one motion; the door
    is half open, the jaws leave 5 mm on both sides, and the block stands between them at the end only.

    Args:
        rng: Draws the door, the vice and where the block is; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_tending, panda()), rng)


def machine_tending_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: as for the Panda, with the block held by suction.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_tending, ur5()), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    wall, stand = near(rng, 0.3, 0.05), near(rng, 0.12, 0.05)
    stands_at = np.array((near(rng, arm.reach - 0.05, 0.05), near(rng, 0.35, 0.04), 0.0))
    picked_at = np.array((near(rng, arm.reach - 0.05, 0.05), near(rng, -0.3, 0.05), 0.0))
    scene = (
        _table(arm)
        .add("wall", to.Box(0.5, 0.03, wall), to.placement((arm.reach, 0.0, wall / 2)))
        .add("stand", to.Box(0.16, 0.16, stand), to.placement(stands_at + np.array((0.0, 0.0, stand / 2))))
    )
    scene = _with_block(scene, arm, "stand")
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=_lifted(arm, scene, picked_at),
        goal=_lies_on(stands_at + np.array((0.0, 0.0, stand))),
        name="pick and place",
    )


def _tending(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    vice = np.array((near(rng, arm.reach - 0.05, 0.04), near(rng, 0.4, 0.03), BED))
    picked_at = np.array((near(rng, arm.reach - 0.05, 0.05), near(rng, -0.35, 0.05), 0.0))
    door = near(rng, 0.55, 0.03)
    scene = _table(arm)
    machine = {
        "bed": ((0.5, 0.4, BED), (vice[0], 0.42, BED / 2)),
        "back": ((0.5, 0.02, 0.7), (vice[0], 0.63, 0.35)),
        "side": ((0.02, 0.4, 0.7), (vice[0] + 0.26, 0.42, 0.35)),
        "door": ((0.5, 0.02, 0.3), (vice[0], 0.2, door + 0.15)),
    }
    for name, (size, at) in machine.items():
        scene = scene.add(name, to.Box(*size), to.placement(at))
    for name, side in (("fixed_jaw", 1.0), ("moving_jaw", -1.0)):
        at = vice + np.array((0.0, side * (SIZE / 2 + GAP + 0.01), 0.02))
        scene = scene.add(name, to.Box(0.1, 0.02, 0.04), to.placement(at))
    scene = _with_block(scene, arm, "bed")
    across = (0.0, 1.0, 0.0)
    straight = to.axis_alignment("block", axis=across, direction=across, tolerance=0.02)
    for name in ("fixed_jaw", "moving_jaw"):
        scene = scene.with_margin(1e-3, "block", name)
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=_lifted(arm, scene, picked_at),
        goal=(*_lies_on(vice), straight),
        waypoints={"home": arm.tip_at(np.array((0.4, 0.0, 0.4)), 0.05)},
        name="machine tending",
    )


def _table(arm: Arm) -> to.Scene:
    return to.Scene(arm.robot).add("table", to.Box(0.9, 1.6, 0.04), to.placement((0.65, 0.0, -0.02)))


def _with_block(scene: to.Scene, arm: Arm, support: str) -> to.Scene:
    """Return the scene with the block in the hand; it may touch the table first and the support last."""
    return (
        scene.add(
            "block",
            to.Box(SIZE, SIZE, SIZE),
            to.placement((0.0, 0.0, SIZE / 2)),
            frame=arm.tip,
            touch_links=arm.hand,
        )
        .allow_contact("lifting", "block", "table", first=0.5)
        .allow_contact("setting down", "block", support, last=0.5)
    )


def _lifted(arm: Arm, scene: to.Scene, point: np.ndarray) -> Mapping[str, float]:
    return arm.at(scene.allow("block", "table"), *_lies_on(point))


def _lies_on(point: np.ndarray) -> tuple[to.Requirement, to.Requirement]:
    return (
        to.frame_placement(
            "block",
            to.placement(point + np.array((0.0, 0.0, SIZE / 2))),
            position_tolerance=(2e-3, 2e-3, 2e-4),
            rotation_tolerance=np.inf,
        ),
        to.axis_alignment("block", direction=(0.0, 0.0, -1.0), tolerance=2e-3),
    )
