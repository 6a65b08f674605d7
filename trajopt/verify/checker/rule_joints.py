"""Rule: joints are within ranges, at the end or at all times."""

import numpy as np
from intervals import exactly
from kinematics import Kinematics
from reading import Fields, below, every, flag, number, record, row, text, unless_null
from requirement import Bools, Requirement, span
from statement import Joint, Statement


def read(value: Fields, statement: Statement) -> Requirement:
    """Read the rule."""
    ranges = row(below(len(statement.joints) + 1), unless_null(number, -np.inf), unless_null(number, np.inf))
    readers = {"kind": text, "always": flag, "ranges": every(ranges)}
    _, always, rows = record("joint positions", value, readers)
    stated: list[tuple[Joint, float, float]] = [(statement.joints[row[0] - 1], *row[1:]) for row in rows]

    def holds(arm: Kinematics) -> Bools:
        taken = arm.motion.bounds[0] if always else arm.motion.positions[-1:]
        within = np.ones(len(taken.low), dtype=np.bool_)
        for joint, low, high in stated:
            at = taken[:, joint.coordinate] * exactly(joint.factor) + exactly(joint.offset)
            least, most = exactly(low) - exactly(statement.excess), exactly(high) + exactly(statement.excess)
            within &= (at.low >= least.high) & (at.high <= most.low)
        return within

    names = [f"{joint.name} in [{low:.6g}, {high:.6g}]" for joint, low, high in stated]
    return Requirement(f"{span(always)} {', '.join(names)}", holds)
