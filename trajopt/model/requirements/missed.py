"""By how much requirements are missed, in words, with a unit where all are measured in the same."""

from collections.abc import Sequence

import numpy as np

from trajopt.model.printed import in_degrees, in_length
from trajopt.model.requirements.axis_alignment import AxisAlignment
from trajopt.model.requirements.distance_between import DistanceBetween
from trajopt.model.requirements.follows_curve import FollowsCurve
from trajopt.model.requirements.frame_placement import FramePlacement
from trajopt.model.requirements.gaze import Gaze
from trajopt.model.requirements.line_of_sight import LineOfSight
from trajopt.model.requirements.point_on_arc import PointOnArc
from trajopt.model.requirements.position_in_region import PositionInRegion
from trajopt.model.requirements.requirement import Requirement

LENGTH, ANGLE = "m", "rad"


def missed_by(amount: float, requirements: Sequence[Requirement]) -> str:
    """Print by how much requirements are missed: 12 mm, 3 deg, or the bare number where units mix.

    Args:
        amount: What is missing, or the sum of it, each part in its own unit [m, rad].
        requirements: What is missed.
    """
    units = {unit for required in requirements for unit in _units(required)}
    if units == {LENGTH}:
        return in_length(amount)
    return in_degrees(amount) if units == {ANGLE} else f"{amount:.3g}"


def _units(required: Requirement) -> tuple[str, ...]:
    """Return the units that a requirement is measured in; an empty one where they are not known."""
    match required:
        case FramePlacement():
            sizes = ((LENGTH, required.position_tolerance), (ANGLE, required.rotation_tolerance))
            return tuple(unit for unit, tolerance in sizes if np.isfinite(tolerance).any())
        case FollowsCurve():
            return (LENGTH, ANGLE) if np.isfinite(required.rotation_tolerance) else (LENGTH,)
        case Gaze():
            ranged = required.nearest > 0.0 or np.isfinite(required.farthest)
            return (ANGLE, LENGTH) if ranged else (ANGLE,)
        case DistanceBetween() | LineOfSight() | PointOnArc() | PositionInRegion():
            return (LENGTH,)
        case AxisAlignment():
            return (ANGLE,)
        case _:
            return ("",)
