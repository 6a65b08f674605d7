"""Rule: at the end a frame is at a placement, within tolerances of position and rotation vector."""

import numpy as np
from flint import arb
from intervals import Floats, Interval, down, enclosed, exactly, joined, product, turned
from kinematics import GridKinematics
from reading import Fields, record, row, size, text, unless_null
from requirement import Bools, StatedRequirement, seen_from
from statement import Statement, place_in


def read(value: Fields, statement: Statement) -> StatedRequirement:
    """Read the rule: the goal's joint is the one that the frame is seen from."""
    place = place_in(len(statement.joints))
    readers = {"kind": text, "frame": text, "place": place, "goal": place}
    tolerance = row(*[unless_null(size, np.inf)] * 3)
    _, name, where, goal, position, rotation = record(
        "frame placement", value, {**readers, "position": tolerance, "rotation": tolerance}
    )
    seen = seen_from(where, goal.joint, statement)
    most = down(np.array([position, rotation]) + statement.excess)

    def holds(arm: GridKinematics) -> Bools:
        turn, origin = (each[-1] for each in seen.placed(arm))
        inward = goal.rotation.transposed
        off = turned(inward, origin - goal.translation).size
        turned_by = rotation_vector(product(inward, turn)) if np.isfinite(rotation).any() else np.zeros(3)
        return np.array([(off <= most[0]).all() and (turned_by <= most[1]).all()])

    at = ", ".join(f"{each:.6g}" for each in goal.translation.low)
    within = [", ".join(f"{each:g}" for each in part) for part in (position, rotation)]
    words = f"at the end {name} at ({at}) m, within ({within[0]}) m and ({within[1]}) rad"
    return StatedRequirement(words, holds)


def rotation_vector(rotation: Interval) -> Floats:
    """Bound the sizes of the numbers of a rotation's vector, axis times angle below pi, (3,) [rad]."""
    skew = (rotation - rotation.transposed) * exactly(0.5)
    axis = joined([skew[2, 1], skew[0, 2], skew[1, 0]], 0)  # times the sine of the angle
    cosine = (rotation[0, 0] + rotation[1, 1] + rotation[2, 2] - exactly(1.0)) * exactly(0.5)
    angle = arb.atan2(_ball(axis.norm()), _ball(cosine))
    return (axis * exactly(enclosed(1 / angle.sinc())[1])).size


def _ball(interval: Interval) -> arb:
    low, high = float(interval.low), float(interval.high)
    return arb(low).union(arb(high)) if np.isfinite((low, high)).all() else arb("nan")
