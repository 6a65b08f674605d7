"""Distances between shapes: of two, inside the carrying link, and to the support of an object."""

from itertools import product

import coal
import numpy as np

from trajopt.geometry.geometry import collision_geometry
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.values.placement import WORLD, Placement
from trajopt.values.printed import in_length
from trajopt.values.shapes.shapes import Shape, bounding_sphere, solids_near

TOUCHING = 2e-3
"""Things closer than this are in contact [m]."""


def gap(first: Placement, shape: Shape, second: Placement, other: Shape) -> float:
    """Return the distance of two shapes, negative if they overlap [m]; infinite for far clouds."""
    (centre, radius), (far, reach) = bounding_sphere(shape), bounding_sphere(other)
    ones = solids_near(shape, first, second * far, reach + TOUCHING)
    others = solids_near(other, second, first * centre, radius + TOUCHING)
    return min((_convex_gap(*one, *each) for one, each in product(ones, others)), default=np.inf)


def inside_carriers(reduced: ReducedModel) -> tuple[str, ...]:
    """Return the attached objects that are inside a link that moves with them, deeper than in contact.

    No motion changes the depth, so planning and judge ignore it: an object in a closed
    finger, or in the palm.
    """
    scene, links = reduced.scene, set(reduced.scene.robot.links)
    depths: dict[tuple[str, str], float] = {}
    for body in reduced.bodies:
        if body.owner in links or scene.holder(body.owner).link == WORLD:
            continue
        for other in reduced.bodies:
            if other.joint == body.joint and other.owner in links:
                deep = -gap(body.placement, body.shape, other.placement, other.shape)
                pair = (body.owner, other.owner)
                depths[pair] = max(deep, depths.get(pair, 0.0))
    return tuple(
        f"{name} is {in_length(deep)} inside {link}: they move together, so nothing keeps them apart"
        for (name, link), deep in depths.items()
        if deep > TOUCHING
    )


def _convex_gap(shape: Shape, first: Placement, other: Shape, second: Placement) -> float:
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


def supports(scene: Scene, name: str, where: Placement) -> tuple[str, ...]:
    """Return the objects, at rest or moved by themselves, that an object touches at time 0.

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
        and any(abs(gap(placed, shape, body.placement, body.shape)) < TOUCHING for placed, shape in own)
    )
    return tuple(dict.fromkeys(found))
