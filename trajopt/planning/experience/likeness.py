"""Likeness: the data by which problems are compared, and the distance between them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from hashlib import sha256
from math import isfinite
from typing import Any, cast

import numpy as np

from trajopt.problem.problem import Problem
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, readonly
from trajopt.values.placement import WORLD
from trajopt.values.shapes.shapes import bounding_box

FARTHEST = 10.0
"""Extent to which walls and floors are cut, beyond the reach of arms: it does not distinguish motions [m]."""
UNLIKE = 1.0
"""Displacement that an object without a counterpart counts as: the reach of an arm [m]."""


@dataclass(frozen=True)
class Likeness:
    """Data by which a problem is compared.

    Attributes:
        key: Must be equal: robot, group, and the kinds of the requirements.
        start: Start of the group's joints, shape (n,) [rad | m].
        goal: The numbers of the goal, shape (g,).
        scene: As `scene_signature` returns it.
    """

    key: str
    start: Floats
    goal: Floats
    scene: Floats


def likeness(problem: Problem) -> Likeness:
    """Return the data by which a problem with one goal is compared."""
    reduced = problem.reduced
    numbers, words = list[float](), list[str]()
    for part in _parts(problem.goals):
        (numbers if isinstance(part, float) else words).append(part)  # pyright: ignore[reportArgumentType]
    kinds = [part for part in _parts(problem.constraints) if isinstance(part, str)]
    carried = sorted(
        f"{name} on {holder}"
        for name in problem.scene.objects
        if (holder := problem.scene.holder(name).link) != WORLD
    )
    robot = (problem.scene.robot.name, *reduced.joint_names)
    whole = "\n".join((*robot, "goal", *words, "constraints", *kinds, "carried", *carried))
    return Likeness(
        sha256(whole.encode()).hexdigest(),
        reduced.start_positions,
        readonly(np.array(numbers)),
        scene_signature(problem.scene),
    )


def scene_signature(scene: Scene) -> Floats:
    """Return positions and sizes of the objects of the world, unordered: shape (objects, 6) [m].

    For each the centre of the axis-aligned box around it, and half its edges. Names do not matter, so that a
    camera may rename its detections each time.
    """
    rows = list[Floats]()
    for name, item in scene.objects.items():
        holder = scene.holder(name)
        if holder.link != WORLD or not item.parts:
            continue
        lower, upper = np.full(3, np.inf), np.full(3, -np.inf)
        for shape, where in item.parts:
            low, high = (np.clip(corner, -FARTHEST, FARTHEST) for corner in bounding_box(shape))
            at = holder.placement * where
            centre = at.rotation @ ((low + high) / 2.0) + at.translation
            half = np.abs(at.rotation) @ ((high - low) / 2.0)
            lower, upper = np.minimum(lower, centre - half), np.maximum(upper, centre + half)
        rows.append(np.concatenate(((lower + upper) / 2.0, (upper - lower) / 2.0)))
    return readonly(np.array(rows).reshape(-1, 6))


def scenes_apart(first: Floats, second: Floats) -> float:
    """Return the mean distance of the objects of two scenes, each from the most similar one [m].

    Args:
        first: The signature of one.
        second: The signature of the other.
    """
    count = len(first) + len(second)
    if not count:
        return 0.0
    if not len(first) or not len(second):
        return UNLIKE
    apart = np.minimum(np.linalg.norm(first[:, None] - second[None], axis=2), UNLIKE)
    return float(apart.min(axis=1).sum() + apart.min(axis=0).sum()) / count


def _parts(value: object) -> Iterator[str | float]:
    """Yield the parts of a value: its numbers, and everything else as text."""
    match value:
        case bool() | None | str():
            yield repr(value)
        case int() | float() | np.integer() | np.floating():
            yield float(value) if isfinite(value) else str(value)
        case Enum():
            yield value.name
        case np.ndarray():
            yield f"array {value.shape}"
            yield from _parts(cast("list[Any]", value.tolist()))
        case Mapping():
            for key, each in cast("Mapping[object, object]", value).items():
                yield str(key)
                yield from _parts(each)
        case _:
            yield type(value).__qualname__
            for each in _members(value):
                yield from _parts(each)


def _members(value: object) -> Sequence[object]:
    """Return the members of a sequence, or the fields of a dataclass; of anything else none."""
    if isinstance(value, Sequence):
        members = cast("Sequence[object]", value)
        return (f"{len(members)} of", *members)
    return [getattr(value, item.name) for item in fields(value)] if is_dataclass(value) else ()
