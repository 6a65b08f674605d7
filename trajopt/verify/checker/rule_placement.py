"""Rules: a frame is at a placement, within tolerances of position and rotation vector, at the end or always.

A rotation vector is the skew part of the rotation, an axis times the sine of the angle, times the angle over
its sine. The skew part and the cosine are linear in the rotation, so each is near its chord.
"""

from functools import partial

import numpy as np
from flint import arb
from intervals import Floats, Interval, down, enclosed, exactly, joined, product, turned, up
from kinematics import GridKinematics
from reading import Fields, record, row, size, text, unless_null
from requirement import Bools, FrameView, StatedRequirement, off_chord, span
from statement import Statement, place_in


def _read(value: Fields, statement: Statement, *, always: bool) -> StatedRequirement:
    place = place_in(len(statement.joints))
    readers = {"kind": text, "frame": text, "place": place, "goal": place}
    tolerance = row(*[unless_null(size, np.inf)] * 3)
    _, name, where, goal, position, rotation = record(
        "frame placement", value, {**readers, "position": tolerance, "rotation": tolerance}
    )
    seen = FrameView(where, goal.joint)
    most = down(np.array([position, rotation]) + statement.excess)

    def worst(values: Floats) -> Floats:
        return np.maximum(values[:-1], values[1:]) if always else values[-1:]

    def holds(arm: GridKinematics) -> Bools:
        turn, origin = seen.placed(arm)
        inward = goal.rotation.transposed
        off = turned(inward, origin - goal.translation).size
        skew, cosine = skew_and_cosine(product(inward, turn))
        off, skew, cosine = worst(off), worst(skew), -worst(-cosine)
        beside, rest = np.zeros(1), np.zeros(1)
        if always:
            beside, rest = off_chord(arm, seen.travel(arm).acceleration), off_chord(arm, seen.turning(arm))
        kept = (up(off + beside[:, None]) <= most[0]).all(axis=1)
        if np.isfinite(rotation).any():
            turned_by = rotation_vectors(up(skew + rest[:, None]), down(cosine - up(1.5 * rest)))
            kept &= (turned_by <= most[1]).all(axis=1)
        return kept

    at = ", ".join(f"{each:.6g}" for each in goal.translation.low)
    turn = (goal.rotation.low.round(6) + 0.0).tolist()
    within = [", ".join(f"{each:g}" for each in part) for part in (position, rotation)]
    words = f"{span(always)} {name}{seen.named(statement)} at ({at}) m, turned by {turn}, within"
    return StatedRequirement(f"{words} ({within[0]}) m and ({within[1]}) rad", holds)


read, read_held = partial(_read, always=False), partial(_read, always=True)


def skew_and_cosine(rotation: Interval) -> tuple[Floats, Floats]:
    """Bound the skew parts of rotations (g, 3, 3) from above, (g, 3), and their cosines from below, (g,)."""
    skew = (rotation - rotation.transposed) * exactly(0.5)
    axis = joined([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], 1)
    trace = rotation[:, 0, 0] + rotation[:, 1, 1] + rotation[:, 2, 2]
    return axis.size, ((trace - exactly(1.0)) * exactly(0.5)).low


def rotation_vectors(skew: Floats, cosine: Floats) -> Floats:
    """Bound the numbers of rotation vectors, (c, 3) [rad]; the angle over its sine grows with the angle."""
    longer = [enclosed(1 / arb(float(each)).acos().sinc())[1] for each in cosine]
    return up(skew * np.array(longer)[:, None])
