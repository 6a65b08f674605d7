"""Joint positions asked for more than once: what all of them together allow."""

from collections.abc import Sequence

import numpy as np

from trajopt.model.limits import EXCESS
from trajopt.model.requirements.joint_positions import JointPositions
from trajopt.model.requirements.requirement import Requirement


def together(required: Sequence[Requirement]) -> tuple[Requirement, ...]:
    """Return requirements with joint positions that name the same joint made one.

    Where several name a joint, the one allows what they share, and asks for the middle of that. Joint
    positions that share nothing stay as they are, and so does what names no joint twice.

    Args:
        required: What must hold at one moment.
    """
    asked = [item for item in required if isinstance(item, JointPositions)]
    names = list(dict.fromkeys(joint for item in asked for joint in item.positions))
    if len(names) == sum(len(item.positions) for item in asked):
        return tuple(required)
    positions, below, above = dict[str, float](), dict[str, float](), dict[str, float]()
    for joint in names:
        naming = [item for item in asked if joint in item.positions]
        lower = max(item.positions[joint] - item.below[joint] for item in naming)
        upper = min(item.positions[joint] + item.above[joint] for item in naming)
        if lower - upper > 2.0 * EXCESS:
            return tuple(required)
        centre = naming[0].positions[joint]
        if len(naming) > 1:
            mean = float(np.mean([item.positions[joint] for item in naming]))
            middle = 0.5 * (lower + upper)
            centre = middle if np.isfinite(middle) else float(np.clip(mean, lower, upper))
        positions[joint] = centre
        below[joint], above[joint] = max(centre - lower, 0.0), max(upper - centre, 0.0)
    others = (item for item in required if not isinstance(item, JointPositions))
    return (JointPositions(positions, below, above), *others)
