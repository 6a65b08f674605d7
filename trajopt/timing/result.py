"""Arguments and results of retiming."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from trajopt.values.arrays import Floats, Printed, Value
from trajopt.values.errors import ShapeError
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory

LEAST_TOLERANCE = 1e-7
"""Smallest tolerance of rounded corners [m | rad]."""


@checked
@dataclass(frozen=True)
class RetimeOptions:
    """Options of `retime`.

    Attributes:
        path_tolerance: Largest deviation of the smooth path from the polyline, by the deviation bound [m];
            without one, by the largest joint difference [rad | m].
        points: Target number of trajectory points. Every knot of the smooth path is also a point.
        passes: Most computations of the profile, on finer grids or with tightened limits.
        remainder: Share of the duration that the final uniform stretch may add without another pass.
        shortest: Shortest duration of a trajectory, including one at rest [s].
    """

    path_tolerance: float = 5e-3
    points: int = 140
    passes: int = 8
    remainder: float = 1e-3
    shortest: float = 1e-2

    def __post_init__(self) -> None:
        """Check the ranges.

        Raises:
            ShapeError: If a number is out of its range.
        """
        ranges = (
            ("path_tolerance", self.path_tolerance, LEAST_TOLERANCE),
            ("points", self.points, 10),
            ("passes", self.passes, 1),
            ("remainder", self.remainder, 0.0),
            ("shortest", self.shortest, 1e-9),
        )
        for name, value, least in ranges:
            if not value >= least:
                raise ShapeError(name, f"must be at least {least:g}, is {value}")


@dataclass(frozen=True, eq=False)
class Retimed(Printed):
    """A trajectory along a smooth path within all limits.

    Attributes:
        trajectory: Starts and ends at rest, quintic between its points.
        deviation: Deviation of the smooth path from the polyline by the deviation bound [m]; without one, the
            largest joint difference [rad | m].
        added_duration: Duration added to hold the limits between points, relative to the first profile, which
            holds them at points only [s]; slightly negative if a finer grid saved more.
        passes: Number of computed profiles.
        binding: Kind of limit (velocity, acceleration, torque, jerk, tool speed) -> share of the duration
            in which it determines the speed; no single limit determines the rest.
    """

    trajectory: Trajectory
    deviation: float
    added_duration: float
    passes: int
    binding: Mapping[str, float]

    def __repr__(self) -> str:
        shares = ", ".join(f"{name} {share:.0%}" for name, share in self.binding.items())
        return f"Retimed({self.trajectory.duration:.3f} s, limited by {shares or 'none'})"


@dataclass(frozen=True)
class RetimeFailure:
    """The path has no timing within the limits.

    Attributes:
        reason: Reason, as a sentence.
        joint: Joint whose limit cannot be held, if it is a single joint.
        place: Position on the path, as a share of its length from 0 (start) to 1 (goal).
    """

    reason: str
    joint: str | None
    place: float


SpeedOfTools: TypeAlias = Callable[[Floats, Floats], Floats]
"""Joint positions and velocities, (S, n) each -> m tool speeds, (S, m) [m/s | rad/s]."""
InverseDynamics: TypeAlias = Callable[[Floats, Floats, Floats], Floats]
"""Joint positions, velocities and accelerations, (S, n) each -> joint torques, (S, n) [Nm | N]."""
DeviationBound: TypeAlias = Callable[[Floats, Floats], Floats]
"""Positions (S, n) on the smooth path and on the polyline -> bound on the travel of any body point, (S,)
[m].
"""


@checked
@dataclass(frozen=True, eq=False)
class ToolLimits(Value):
    """Limited tool speeds.

    Attributes:
        speeds: Computes the speeds; they must scale with the joint velocities.
        limit: Largest speeds, positive, shape (m,) [m/s | rad/s].
        names: Name of each speed for messages.
    """

    speeds: SpeedOfTools
    limit: Floats
    names: tuple[str, ...]
