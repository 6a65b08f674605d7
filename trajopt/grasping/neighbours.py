"""What is around a thing that is grasped or put down: what it touches, and what it has to pass close by."""

import coal
import numpy as np

from trajopt.arrays import Floats
from trajopt.grasping.gripper import Gripper
from trajopt.model.placement import Placement
from trajopt.model.reduced import ReducedModel
from trajopt.model.requirements import WORLD
from trajopt.model.scene import Scene
from trajopt.model.shapes import Shape
from trajopt.query import Query
from trajopt.query.geometry import collision_geometry

TOUCHING = 2e-3
"""What is nearer than this is stood on, or leant against [m]."""
SHARE = 0.5
"""Share of a gap at the end of a straight motion that is asked for as clearance all along it."""


def touched(scene: Scene, name: str, where: Placement) -> tuple[str, ...]:
    """Return the objects at rest that an object touches at a placement in the world.

    Args:
        scene: The scene.
        name: The object.
        where: Its placement in the world.
    """
    own = [(where * placed, shape) for shape, placed in scene.object(name).parts]
    found = (
        body.owner
        for body in scene.object_bodies()
        if body.owner != name
        and body.frame == WORLD
        and any(_gap(placed, shape, body.placement, body.shape) < TOUCHING for placed, shape in own)
    )
    return tuple(dict.fromkeys(found))


def hand_meets(reduced: ReducedModel, gripper: Gripper, tool: Placement) -> str:
    """Say what a hand would be inside of with its tool at a placement, whatever the arm does.

    Args:
        reduced: A model in which the fingers stand as they should.
        gripper: The gripper.
        tool: Placement of its tool frame in the world.

    Returns:
        Which link and which object; empty for none.
    """
    scene = reduced.scene
    joint, held = reduced.attachment(gripper.tool)
    hand = tool * held.inverse()
    links = [body for body in reduced.bodies if body.owner in gripper.links and body.joint == joint]
    for other in reduced.bodies:
        if other.joint != 0 or other.owner in scene.robot.links:
            continue
        for body in links:
            if scene.may_touch(body.owner, other.owner):
                continue
            if _gap(hand * body.placement, body.shape, other.placement, other.shape) < 0.0:
                return f"{body.owner} is inside {other.owner}"
    return ""


def with_room(reduced: ReducedModel, positions: Floats) -> Scene:
    """Return the scene with smaller margins where a configuration is nearer to something than them.

    A straight motion that ends at a grasp passes close by all the way: half of what is left at its end is
    asked for. What touches there keeps no margin.

    Args:
        reduced: The model.
        positions: The group's positions where the straight motion begins or ends, shape (n,).
    """
    scene = reduced.scene
    contacts = Query(reduced).close_pairs(positions[None], reduced.pairs.margin)
    gaps: dict[frozenset[str], float] = {}
    for pair, distance in zip(contacts.pair.tolist(), contacts.distance.tolist(), strict=True):
        owners = frozenset(reduced.owners(pair))
        gaps[owners] = min(gaps.get(owners, np.inf), distance)
    for owners, gap in gaps.items():
        first, second = sorted(owners)
        scene = scene.with_margin(SHARE * gap if gap > TOUCHING else 0.0, first, second)
    return scene


def _gap(first: Placement, shape: Shape, second: Placement, other: Shape) -> float:
    """Return how far two shapes are apart, negative where they overlap [m]."""
    return float(
        coal.distance(
            collision_geometry(shape),
            _transform(first),
            collision_geometry(other),
            _transform(second),
            coal.DistanceRequest(),
            coal.DistanceResult(),
        )
    )


def _transform(placement: Placement) -> coal.Transform3s:
    return coal.Transform3s(np.array(placement.rotation), np.array(placement.translation))
