"""Grasps of simple shapes: from every side on which the fingers reach around them."""

from collections.abc import Iterator
from functools import singledispatch

import numpy as np

from trajopt.scene.scene import Scene
from trajopt.tasks.grasping.grasp import FORCE, Grasp
from trajopt.tasks.grasping.gripper import Gripper
from trajopt.values.arrays import Floats, floats, one_of, positive, readonly
from trajopt.values.errors import ModelError, shown
from trajopt.values.placement import Placement
from trajopt.values.shapes.shapes import Box, Cylinder, Shape, Sphere

SPARE = 0.01
"""How far each pad is from the object during the approach, where the gripper opens so far [m]."""
LEAST_SPARE = 0.003
"""The smallest such distance: an object that leaves less is too wide [m]."""
REACH = 0.03
"""How far the middle of the pads gets over an object's edge before the hand would touch it [m]."""
AROUND = 8
"""Directions around a cylinder."""

Direction = tuple[Floats, str]
"""A unit vector (3,) and its name."""

FACES: tuple[Direction, ...] = tuple(
    (readonly(sign * np.eye(3)[axis]), f"{'+' if sign > 0.0 else '-'}{'xyz'[axis]}")
    for axis, sign in ((2, 1.0), (0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, -1.0))
)
"""Outward normals of a box: the top first."""


def grasps_of(
    scene: Scene, name: str, gripper: Gripper, *, force: float = FORCE, reach: float = REACH
) -> tuple[Grasp, ...]:
    """Return grasps of an object that is one box, cylinder or sphere: from above first, in its own frame.

    Each comes twice, the second time with the hand turned half round. Those for which the gripper does
    not open wide enough are left out; which of the others can be reached is found by planning.

    Args:
        scene: The scene.
        name: The object.
        gripper: The gripper.
        force: That each finger presses with [N].
        reach: How far the middle of the pads gets over the object's edge at most [m].

    Raises:
        ObjectNotFound: If there is none of that id.
        ModelError: If it is of another shape, or of several.
    """
    one_of("gripper", gripper, Gripper)
    positive("force", force)
    positive("reach", reach)
    item = one_of("scene", scene, Scene).object(one_of("name", name, str))
    if len(item.parts) != 1:
        raise ModelError(f"object {shown(name)} has {len(item.parts)} shapes; define its grasps yourself")
    shape, where = item.parts[0]
    found: list[Grasp] = []
    for width, grip, label in grips(shape, reach):
        if width + 2.0 * LEAST_SPARE > gripper.widest or width < gripper.narrowest:
            continue
        for turned in (False, True):
            half = np.diag((-1.0, -1.0, 1.0)) if turned else np.eye(3)
            held = where * grip * Placement(readonly(half)) * gripper.axes.inverse()
            found.append(
                Grasp(
                    placement=held,
                    width=width,
                    opening=min(width + 2.0 * SPARE, gripper.widest),
                    force=force,
                    name=label + (", turned" if turned else ""),
                )
            )
    return tuple(found)


@singledispatch
def grips(shape: Shape, reach: float) -> Iterator[tuple[float, Placement, str]]:
    """Yield the width between the pads, the placement of the pads in the shape's frame, and a name.

    In that placement z is the direction of approach and y that of closing.

    Args:
        shape: The shape.
        reach: How far the middle of the pads gets over the edge at most [m].
    """
    raise ModelError(f"no grasps are known of a {type(shape).__name__}; define them yourself")


@grips.register
def _(shape: Box, reach: float) -> Iterator[tuple[float, Placement, str]]:
    yield from _of_box((shape.x, shape.y, shape.z), reach)


@grips.register
def _(shape: Sphere, reach: float) -> Iterator[tuple[float, Placement, str]]:
    # Only pads that meet at the widest place hold a sphere.
    if shape.radius <= reach:
        yield from _of_box((2.0 * shape.radius, 2.0 * shape.radius, 2.0 * shape.radius), reach)


@grips.register
def _(shape: Cylinder, reach: float) -> Iterator[tuple[float, Placement, str]]:
    diameter = 2.0 * shape.radius
    angles = [2.0 * np.pi * k / AROUND for k in range(AROUND)]
    over = max(shape.length / 2.0 - reach, 0.0)
    upward = np.array((0.0, 0.0, 1.0))
    for side, label in ((1.0, "+z"), (-1.0, "-z")):
        for angle in angles[: AROUND // 2]:
            closing = np.array((np.cos(angle), np.sin(angle), 0.0))
            grip = _pads(side * over * upward, -side * upward, closing)
            yield diameter, grip, f"from {label}, closing at {np.rad2deg(angle):.0f} degrees"
    if shape.radius > reach:
        return
    for angle in angles:
        outward = np.array((np.cos(angle), np.sin(angle), 0.0))
        grip = _pads(np.zeros(3), -outward, np.cross(upward, outward))
        yield diameter, grip, f"from the side at {np.rad2deg(angle):.0f} degrees"


def _of_box(size: tuple[float, float, float], reach: float) -> Iterator[tuple[float, Placement, str]]:
    for outward, side in FACES:
        across = int(np.argmax(np.abs(outward)))
        over = max(size[across] / 2.0 - reach, 0.0)
        for axis in (axis for axis in range(3) if axis != across):
            grip = _pads(over * outward, -outward, np.eye(3)[axis])
            yield size[axis], grip, f"from {side}, closing along {'xyz'[axis]}"


def _pads(middle: Floats, approach: Floats, closing: Floats) -> Placement:
    axes = np.stack((np.cross(closing, approach), closing, approach), axis=1)
    return Placement(floats("axes", axes, (3, 3)), floats("middle", middle, (3,)))
