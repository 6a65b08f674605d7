"""Named states: a home that is valid, and the two ends of a gripper's stroke."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from trajopt.geometry import Query
from trajopt.lab.srdf.groups import ProposedGroup
from trajopt.lab.srdf.judged_pairs import all_joints_free
from trajopt.robot.bodies import CollisionBody
from trajopt.robot.limits import draw_positions
from trajopt.robot.loading.pinocchio_model import link_placement
from trajopt.robot.robot import Robot
from trajopt.scene.reduced import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.shapes.shapes import bounding_sphere

TRIED = 2000
"""Random configurations tried where neither zero nor the middle of the limits is valid."""
HOME_MARGIN = 0.01
"""Clearance that a home state has, where one can be found [m]."""


def home_positions(
    robot: Robot, disabled: frozenset[frozenset[str]], *, rng: np.random.Generator
) -> Floats | None:
    """Return positions of all driven joints that touch nothing: zero, the middle, or a configuration near it.

    Args:
        robot: The robot.
        disabled: Pairs of links that may touch.
        rng: Draws configurations where neither zero nor the middle of the limits is valid.

    Returns:
        Shape (n,) [rad | m], n driven joints; None if all that was tried collides.
    """
    free = all_joints_free(robot)
    bare = replace(free.scene.robot, disabled_pairs=disabled)
    reduced = reduce_model(Scene(bare, margin=0.0), free.group, free.start)
    limits = reduced.limits
    limited = np.isfinite(limits.lower) & np.isfinite(limits.upper)
    middle = np.zeros(len(limited))
    middle[limited] = 0.5 * (limits.lower[limited] + limits.upper[limited])
    drawn = draw_positions(limits, TRIED, rng=rng)
    nearest = np.argsort(np.abs(drawn - middle).max(axis=1))
    inside = ((limits.lower <= 0.0) & (limits.upper >= 0.0)).all()
    tried = np.concatenate((np.zeros((int(inside), len(middle))), middle[None], drawn[nearest]))
    for margin in (HOME_MARGIN, 0.0):
        reach = np.full(len(reduced.pairs.margin), max(margin, 1e-12))
        touching = np.zeros(len(tried), dtype=np.bool_)
        touching[Query(reduced).close_pairs(tried, reach).sample] = True
        if not touching.all():
            return tried[int(np.argmin(touching))]
    return None


def gripper_states(robot: Robot, group: ProposedGroup) -> Mapping[str, Mapping[str, float]]:
    """Return the states "open" and "close" of a gripper: the ends of its joints' strokes.

    Open is where its fingers' collision bodies are farther from each other on average. The shape of
    one finger, which closes on the palm, does not tell which end is which.

    Args:
        robot: The robot.
        group: One of its grippers.

    Returns:
        Joint -> position [rad | m] by state, of the driven joints; empty for one finger, and where a stroke
        has no ends.
    """
    limits = robot.limits.take(robot.index(group.driven))
    if len(group.joints) < 2 or not group.driven or not np.isfinite([limits.lower, limits.upper]).all():
        return {}
    bodies = [body for body in robot.bodies if body.owner in group.links and body.owner != group.tip]
    ends = [dict(zip(group.driven, side.tolist(), strict=True)) for side in (limits.lower, limits.upper)]
    spread = [_spread(robot, bodies, robot.positions(end)) for end in ends]
    wide, narrow = (0, 1) if spread[0] > spread[1] else (1, 0)
    return {"open": ends[wide], "close": ends[narrow]}


def _spread(robot: Robot, bodies: Sequence[CollisionBody], positions: Floats) -> float:
    """Return the mean distance of bodies' centres from the middle of them all [m]."""
    if not bodies:
        return 0.0
    centres = np.array(
        [
            link_placement(robot.model, body.frame, positions)
            * (body.placement * bounding_sphere(body.shape)[0])
            for body in bodies
        ]
    )
    return float(np.linalg.norm(centres - centres.mean(axis=0), axis=1).mean())
