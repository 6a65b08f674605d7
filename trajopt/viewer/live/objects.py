"""Objects edited by hand: added beside the robot, moved, resized, grasped, released, removed.

Each edit is a function from a scene to a scene.
"""

from collections.abc import Iterator, Mapping
from dataclasses import fields, replace
from enum import Enum
from itertools import count
from math import pi
from typing import TypeAlias, get_args

import numpy as np

from trajopt.optimise.kinematics import validity
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.errors import ModelError, shown
from trajopt.values.placement import WORLD, Placement, placement
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Cylinder, Plane, Shape, Sphere, bounding_box
from trajopt.viewer.live.goal import hand_at

Sized: TypeAlias = Box | Cylinder | Sphere | Cone | Capsule
"""Shapes whose sizes are a few numbers."""
SMALLEST = 1e-3
"""No size is smaller: a slider at its end makes no object without volume [m]."""
DIRECTIONS = (pi / 4, -pi / 4, pi / 2, -pi / 2, 3 * pi / 4, -3 * pi / 4, 0.0, pi)
"""Directions of new objects about the robot's base, relative to the hand; preferably to the side."""
TOUCH = 1e-3
"""Accepted overlap of an object with the bounds of its support [m]."""
NEAREST = 0.3
"""No nearer to the base than this is an object put [m]."""


class Kind(Enum):
    """Kinds of objects that are put up: each a shape of a size that a hand could grasp."""

    BOX = "box"
    CYLINDER = "cylinder"
    SPHERE = "sphere"

    @property
    def shape(self) -> Sized:
        """The shape of a new one."""
        match self:
            case Kind.BOX:
                return Box(0.1, 0.1, 0.1)
            case Kind.CYLINDER:
                return Cylinder(0.05, 0.2)
            case Kind.SPHERE:
                return Sphere(0.05)


def sizes_of(scene: Scene, name: str) -> Mapping[str, float]:
    """Return the sizes of an object that can be changed, by field [m]; empty for a mesh."""
    parts = scene.object(name).parts
    if len(parts) != 1 or not isinstance(parts[0][0], get_args(Sized)):
        return {}
    shape: Shape = parts[0][0]
    return {each.name: float(getattr(shape, each.name)) for each in fields(shape) if each.init}


def added(reduced: ReducedModel, kind: Kind) -> tuple[Scene, str]:
    """Add an object on the ground beside the robot, at a place without contact if there is one.

    Returns:
        The scene with it, and its name.
    """
    name = next(each for each in _names(kind) if each not in reduced.scene.objects)
    scenes = [reduced.scene.add(name, kind.shape, where) for where in _places(reduced, kind)]
    free = (scene for scene in scenes if _touches_nothing(scene, reduced))
    return next(free, scenes[0]), name


def resized(scene: Scene, name: str, sizes: Mapping[str, float]) -> Scene:
    """Resize an object; its allowed contacts stay.

    Args:
        scene: The scene.
        name: The object.
        sizes: By field [m].

    Raises:
        ObjectNotFound: If there is none of that name.
        ModelError: If it is not a single shape with sizes.
    """
    item = scene.object(name)
    if not sizes_of(scene, name):
        raise ModelError(f"{shown(name)} is no single shape with sizes: it stays as large as it is")
    ((shape, where),) = item.parts
    larger = replace(shape, **{key: max(value, SMALLEST) for key, value in sizes.items()})
    return replace(scene, objects={**scene.objects, name: replace(item, parts=((larger, where),))})


def moved(scene: Scene, name: str, where: Placement) -> Scene:
    """Place an object in the world.

    Raises:
        ObjectNotFound: If there is none of that name.
        ModelError: If it is attached to the robot.
    """
    if is_carried(scene, name):
        raise ModelError(f"the robot carries {shown(name)}: put it down first")
    return scene.move(name, where, frame=WORLD)


def grasped(reduced: ReducedModel, name: str, hand: str) -> Scene:
    """Attach an object to the hand at its present place; links of the hand may touch it."""
    joint = reduced.attachment(hand)[0]
    gripper = [link for link in reduced.scene.robot.links if reduced.attachment(link)[0] == joint]
    at = reduced.all_positions(reduced.start_positions)
    return reduced.scene.attach(name, hand, at=at, touch_links=gripper)


def put_down(reduced: ReducedModel, name: str) -> Scene:
    """Detach an object at its present place."""
    return reduced.scene.detach(name, at=reduced.all_positions(reduced.start_positions))


def is_carried(scene: Scene, name: str) -> bool:
    """Return whether an object is attached to the robot."""
    return scene.holder(name).link != WORLD


def _names(kind: Kind) -> Iterator[str]:
    yield kind.value
    yield from (f"{kind.value} {number}" for number in count(2))


def _places(reduced: ReducedModel, kind: Kind) -> Iterator[Placement]:
    """Yield places on the ground about the base, as far from it as the hand is."""
    robot = reduced.scene.robot
    base = reduced.scene.placement_of(robot.links[0], reduced.start).translation
    hand = hand_at(reduced, robot.links[-1], reduced.start_positions).translation - base
    far, ahead = max(float(np.linalg.norm(hand[:2])), NEAREST), float(np.arctan2(hand[1], hand[0]))
    low = min(float(base[2]), 0.0) + _height(kind.shape) / 2.0
    for turn in DIRECTIONS:
        x, y = base[:2] + far * np.array((np.cos(ahead + turn), np.sin(ahead + turn)))
        yield placement((float(x), float(y), low))


def _height(shape: Sized) -> float:
    match shape:
        case Box():
            return shape.z
        case Sphere():
            return 2.0 * shape.radius
        case Cylinder() | Cone():
            return shape.length
        case Capsule():
            return shape.length + 2.0 * shape.radius


def _touches_nothing(scene: Scene, reduced: ReducedModel) -> bool:
    """Return whether the last object of a scene is clear of the robot and of the bounds of the others."""
    there = reduce_model(scene, reduced.group, reduced.start)
    *others, last = (name for name in scene.objects if not is_carried(scene, name))
    mine = _bounds(scene, last)[0]
    every = np.array([each for other in others for each in _bounds(scene, other)]).reshape(-1, 2, 3)
    apart = (every[:, 0] > mine[1] - TOUCH) | (every[:, 1] < mine[0] + TOUCH)
    return bool(apart.any(axis=1).all()) and validity(there, there.start_positions).valid


def _bounds(scene: Scene, name: str) -> list[Floats]:
    """Return the lower and upper corner of each part of an object in the world, (2, 3) each [m]."""
    found: list[Floats] = []
    for shape, inner in scene.object(name).parts:
        if not isinstance(shape, Plane):
            lower, upper = bounding_box(shape)
            where = scene.holder(name).placement * inner
            half, centre = (upper - lower) / 2.0, where * ((lower + upper) / 2.0)
            reach = np.abs(where.rotation) @ half
            found.append(np.stack((centre - reach, centre + reach)))
    return found
