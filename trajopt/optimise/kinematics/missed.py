"""By how much a configuration misses what is required of it, in words: 12 mm and 0.9 deg."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from trajopt.geometry import Query
from trajopt.optimise.terms.joint_positions import without_followers
from trajopt.optimise.terms.requirement import constrain
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import Requirement
from trajopt.problem.residual import WHOLE, units_of
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats
from trajopt.values.printed import in_degrees, in_length

SHOWN: Mapping[str, Callable[[float], str]] = {"m": in_length, "rad": in_degrees, "": "{:.3g}".format}
"""How what is missed is printed, by its unit."""


def missed_at(reduced: ReducedModel, required: Sequence[Requirement], positions: Floats) -> str:
    """Say by how much a configuration misses requirements: of each unit what is farthest off.

    Args:
        reduced: The robot and its surroundings.
        required: What should hold there.
        positions: The configuration, shape (n,) [rad | m].

    Returns:
        "12 mm", "12 mm and 0.9 deg", "0.2" of what has no unit.
    """
    motion = Motion.single(positions, Query(reduced))
    missed: dict[str, float] = {"m": 0.0, "rad": 0.0, "": 0.0}
    for item in without_followers(required, reduced):
        for bound in constrain(item, reduced, WHOLE, inset=0.0):
            rows, units = bound.residual.linearise(motion), units_of(bound.residual) or ("",)
            lower, upper = bound.bounds(rows)
            outside = np.maximum(lower - rows.value, rows.value - upper)
            for component, off in zip(rows.component.tolist(), outside.tolist(), strict=True):
                unit = units[component if len(units) > 1 else 0]
                missed[unit] = max(missed[unit], off if off > bound.tolerance else 0.0)
    said = " and ".join(SHOWN[unit](off) for unit, off in missed.items() if off > 0.0)
    return said or "next to nothing"  # of what is aimed at inside the tolerances
