"""What retiming returns: a timed trajectory, or the reason why there is none."""

from collections.abc import Mapping
from dataclasses import dataclass

from trajopt.model.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class Retimed:
    """A trajectory along a smooth path that holds every limit.

    Attributes:
        trajectory: Starts and ends at rest, quintic between its points.
        deviation: How far the smooth path leaves the polyline, by the measure of the deviation
            bound [m], or the largest joint difference [rad | m] without one.
        added_duration: What keeping the limits between the points too has cost, against the
            first profile, which keeps them at the points only [s]; a trifle below 0 where a finer grid
            has gained more.
        passes: How many times the profile was computed.
        binding: Kind of limit (velocity, acceleration, torque, jerk, tool speed) -> part of the duration
            for which it decides how fast the motion is; what is missing to 1 no limit decides alone.
    """

    trajectory: Trajectory
    deviation: float
    added_duration: float
    passes: int
    binding: Mapping[str, float]


@dataclass(frozen=True)
class RetimeFailure:
    """No timing of the path holds the limits.

    Attributes:
        reason: A sentence that says why.
        joint: The joint whose limit cannot be held, where it is one joint.
        place: Where on the path, as a part of its length from 0 (start) to 1 (goal).
    """

    reason: str
    joint: str | None
    place: float
