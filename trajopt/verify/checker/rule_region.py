"""Rules: a point of a frame is in one of several convex shapes; balls or cubes of a cloud are in parts."""

from collections.abc import Mapping

import numpy as np
from intervals import Floats, Interval, down, turned, up
from kinematics import GridKinematics
from reading import Fields, below, demand, every, flag, numbers, one_of, record, row, size, text
from requirement import Bools, FrameView, StatedRequirement, off_chord, span
from shapes import Hull, Shape
from statement import ConvexPart, FixedPlace, Statement, place_in

SIZES: Mapping[str, int] = {"box": 3, "sphere": 1, "cylinder": 2, "half-space": 0}
"""Shapes, and how many sizes they have: edges; radius; radius and length; half-spaces are below z = 0."""


def read(value: Fields, statement: Statement) -> StatedRequirement:
    """Read the rule: the joint of all members is the one that the frame is seen from."""
    place = place_in(len(statement.joints))
    member = row(one_of(SIZES), every(size, 3), place)
    readers = {"kind": text, "frame": text, "place": place, "members": every(member), "always": flag}
    _, name, where, members, always = record("position in region", value, readers)
    joints = {at.joint for _, _, at in members}
    fits = len(joints) == 1 and all(len(sizes) == SIZES[kind] for kind, sizes, _ in members)
    demand(fits, "a region needs members of one joint, each with the sizes of its shape")
    seen = FrameView(where, joints.pop())

    def holds(arm: GridKinematics) -> Bools:
        _, origin = seen.placed(arm)
        depth = [beyond(kind, np.array(sizes), at, origin) for kind, sizes, at in members]
        if not always:
            return np.any([each[-1:] <= statement.excess for each in depth], axis=0)
        # A convex shape that holds both ends of a chord, with room, holds what is near it.
        room = off_chord(arm, seen.travel(arm).acceleration)
        return np.any(
            [up(np.maximum(each[:-1], each[1:]) + room) <= statement.excess for each in depth], axis=0
        )

    named = [f"a {kind} {sizes} at {at.translation.low.tolist()} m" for kind, sizes, at in members]
    return StatedRequirement(f"{span(always)} {name}{seen.named(statement)} in {' or '.join(named)}", holds)


def beyond(kind: str, sizes: Floats, place: FixedPlace, points: Interval) -> Floats:
    """Bound how far points (g, 3) are outside of a shape, negative inside, from above (g,) [m]."""
    local = turned(place.rotation.transposed, points - place.translation)
    if kind == "half-space":
        return local[..., 2].high
    if kind == "sphere":
        return up(local.norm().high - sizes[0])
    if kind == "cylinder":
        across, along = local[..., :2].norm().high, local[..., 2].size
        return np.maximum(up(across - sizes[0]), up(along - sizes[1] / 2.0))
    return up(local.size - sizes / 2.0).max(axis=-1)


def read_cloud(value: Fields, statement: Statement) -> StatedRequirement:
    """Read the rule of a cloud: parts of its owner, and the centres in each of them, in the part's frame."""
    inside = every(row(below(len(statement.parts)), numbers(None, 3)))
    readers = {"kind": text, "owner": text, "cubes": flag, "size": size, "inside": inside}
    _, owner, cubes, reach, rows = record("cloud", value, readers)
    parts: list[tuple[ConvexPart, Floats]] = [(statement.parts[part], centres) for part, centres in rows]
    demand(all(part.owner == owner for part, _ in parts), "a cloud must be in parts of its own")

    def holds(_: GridKinematics) -> Bools:
        return np.array([all(_contains(part.shape, centres, reach, cubes) for part, centres in parts)])

    solids = f"{sum(len(each) for _, each in parts)} {'cubes' if cubes else 'balls'} of {owner}"
    words = f"{solids}, each {2000.0 * reach:g} mm wide, are within {len(parts)} of its parts"
    return StatedRequirement(words, holds)


def _contains(shape: Shape, centres: Floats, reach: float, cubes: bool) -> bool:
    """Return whether a part has all corners of a box, and is around balls or cubes with centres (n, 3)."""
    if not isinstance(shape, Hull):
        return False
    low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
    corners = np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 1, 3)
    whole = (corners == shape.vertices).all(axis=2).any(axis=1).all()
    out = reach if cubes else float(up(reach - shape.radius)) if reach > shape.radius else 0.0
    sides = (down(centres - out), up(centres + out)) if out else (centres, centres)
    return bool(whole and (sides[0] >= low).all() and (sides[1] <= high).all())
