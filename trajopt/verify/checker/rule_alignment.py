"""Rule: an axis of a frame points along a direction, within a cone, at the end or at all times."""

import numpy as np
from flint import arb
from intervals import dot, down, enclosed, exactly, normalised, turned
from kinematics import GridKinematics
from reading import Fields, below, demand, direction, flag, record, size, text
from requirement import Bools, FrameView, StatedRequirement, off_chord, span
from statement import FixedPlace, Statement


def read(value: Fields, statement: Statement) -> StatedRequirement:
    """Read the rule: axis and direction are in the frames of the two joints."""
    joint, axis_of = below(len(statement.joints) + 1), direction(3, normalised)
    readers = {"kind": text, "frame": text, "joint": joint, "axis": axis_of, "reference": joint}
    _, name, carrier, axis, reference, along, tolerance, always = record(
        "axis alignment", value, {**readers, "direction": axis_of, "tolerance": size, "always": flag}
    )
    seen = FrameView(FixedPlace(carrier, exactly(np.eye(3)), exactly(np.zeros(3))), reference)
    angle = max(float(down(tolerance + statement.excess)), 0.0)
    demand(angle <= 3.14, "an axis must be aligned to within 3.14 rad")

    def holds(arm: GridKinematics) -> Bools:
        turn, _ = seen.placed(arm)
        inner = dot(turned(turn, axis), along).low
        least = enclosed(arb(angle).cos())[1]
        if not always:
            return inner[-1:] >= least
        return np.minimum(inner[:-1], inner[1:]) - off_chord(arm, seen.turning(arm)) - 1e-15 >= least

    one, other = (", ".join(f"{each:.6g}" for each in side.low) for side in (axis, along))
    words = f"{span(always)} axis ({one}) of {name}{seen.named(statement)} along ({other})"
    return StatedRequirement(f"{words}, within {tolerance:.6g} rad", holds)
