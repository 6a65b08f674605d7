"""An arm reaches into a cage between its bars."""

from functools import partial

import numpy as np

import trajopt as to

from .arms import Arm, panda, pointing, ur5, with_rod, xarm7
from .drawing import drawn, near


def cage_panda(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the Panda.

    What is hard: bars on all sides and across the top; the hand fits between them only where it
    does not cross one, and the forearm must follow without touching the top.

    Args:
        rng: Draws where the cage stands, its bars and the point to reach; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, panda()), rng)


def cage_ur5(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the UR5.

    What is hard: a rod in its flange enters, and no joint is to spare.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, ur5()), rng)


def cage_xarm7(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the xArm7.

    What is hard: its bare flange must go in between the bars, and its wrist with it.

    Args:
        rng: As for the Panda; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, xarm7()), rng)


def _problem(arm: Arm, rng: np.random.Generator | None) -> to.Problem:
    side, height, thick = near(rng, 0.46, 0.04), near(rng, 0.42, 0.06), 0.012
    upright, across = to.Cylinder(thick, height), to.Box(2 * thick, side, 2 * thick)
    corner = side / 2
    parts: list[tuple[to.Cylinder | to.Box, to.Placement]] = [
        (upright, to.placement((x * corner, y * corner, height / 2))) for x in (-1, 1) for y in (-1, 1)
    ]
    parts += [(upright, to.placement((corner, y * side / 6, height / 2))) for y in (-1, 1)]
    parts += [
        (upright, to.placement((x * side / 6, y * corner, height / 2))) for x in (-1, 1) for y in (-1, 1)
    ]
    parts += [(across, to.placement((x * corner, 0.0, height))) for x in (-1.0, 0.15, 1.0)]
    parts += [
        (across, to.placement((0.0, y * corner, height), rpy=(0.0, 0.0, np.pi / 2))) for y in (-1.0, 1.0)
    ]
    at, turn = near(rng, 0.0, 0.4), near(rng, 0.0, 0.3)
    away = near(rng, arm.reach, 0.03)
    stands = to.placement(rpy=(0.0, 0.0, at)) * to.placement((away, 0.0, 0.0), rpy=(0.0, 0.0, turn))
    scene = (
        to.Scene(arm.robot)
        .add("table", to.Box(1.0, 1.6, 0.04), to.placement((0.7, 0.0, -0.021)))
        .add("cage", parts, stands)
        .add("part", to.Box(0.05, 0.05, 0.05), to.placement((0.02, 0.0, 0.026)), frame="cage")
    )
    frame = arm.tip
    if arm is ur5():
        scene, frame = with_rod(arm, scene), "rod_tip"
    inside = stands * np.array((near(rng, -0.03, 0.05), near(rng, 0.03, 0.08), near(rng, 0.17, 0.05)))
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, *pointing(arm, (0.2, -0.4, 0.7), (0.0, 0.0, -1.0), cone=1.5, frame=frame)),
        goal=pointing(
            arm,
            tuple(inside.tolist()),
            (float(np.cos(at)), float(np.sin(at)), -1.0),
            cone=0.6,
            position_tolerance=0.01,
            frame=frame,
        ),
        name="cage",
    )
