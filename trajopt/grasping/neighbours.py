"""What is around a thing that is grasped or put down: what it touches, and what it has to pass close by."""

import coal
import numpy as np

from trajopt.arrays import Floats
from trajopt.model.placement import Placement
from trajopt.model.reduced import ReducedModel
from trajopt.model.requirements import WORLD
from trajopt.model.scene import Scene
from trajopt.query import query_of
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
    found: list[str] = []
    own = [(where * placed, shape) for shape, placed in scene.object(name).parts]
    for body in scene.object_bodies():
        if body.owner == name or body.frame != WORLD or body.owner in found:
            continue
        for placed, shape in own:
            result = coal.DistanceResult()
            gap = coal.distance(
                collision_geometry(shape),
                _transform(placed),
                collision_geometry(body.shape),
                _transform(body.placement),
                coal.DistanceRequest(),
                result,
            )
            if gap < TOUCHING:
                found.append(body.owner)
                break
    return tuple(found)


def with_room(reduced: ReducedModel, positions: Floats) -> Scene:
    """Return the scene with smaller margins where a configuration is nearer to something than them.

    A straight motion that ends at a grasp passes close by all the way: half of what is left at its end is
    asked for. What touches there keeps no margin.

    Args:
        reduced: The model.
        positions: The group's positions where the straight motion begins or ends, shape (n,).
    """
    scene = reduced.scene
    contacts = query_of(reduced).near(positions[None], reduced.pairs.margin)
    gaps: dict[frozenset[str], float] = {}
    for pair, distance in zip(contacts.pair.tolist(), contacts.distance.tolist(), strict=True):
        owners = frozenset(reduced.owners(pair))
        gaps[owners] = min(gaps.get(owners, np.inf), distance)
    for owners, gap in gaps.items():
        first, second = sorted(owners)
        scene = scene.with_margin(SHARE * gap if gap > TOUCHING else 0.0, first, second)
    return scene


def _transform(placement: Placement) -> coal.Transform3s:
    return coal.Transform3s(np.array(placement.rotation), np.array(placement.translation))
