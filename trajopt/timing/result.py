"""Options of retiming, and its results."""

from collections.abc import Mapping
from dataclasses import dataclass

from trajopt.values.arrays import Printed
from trajopt.values.errors import ShapeError
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory

LEAST_TOLERANCE = 1e-7
"""Corners are never rounded more tightly than this [m | rad]."""


@checked
@dataclass(frozen=True)
class RetimeOptions:
    """Options of `retime`.

    Attributes:
        path_tolerance: How far the smooth path may leave the polyline, by the measure of the
            deviation bound [m]; without such a bound, by the largest joint difference [rad | m].
        points: Points of the trajectory to aim at. Every knot of the smooth path is a
            point too, so that a path with many knots gets more.
        passes: Most times that the profile is computed, on finer grids or with tightened limits.
        remainder: Part of the duration that the final uniform stretch may add without another pass.
        shortest: Least duration of any trajectory, one that stands still included [s].
    """

    path_tolerance: float = 5e-3
    points: int = 140
    passes: int = 8
    remainder: float = 1e-3
    shortest: float = 1e-2

    def __post_init__(self) -> None:
        """Refuse numbers that make no sense.

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
    """A trajectory along a smooth path that holds every limit.

    Attributes:
        trajectory: Starts and ends at rest, quintic between its points.
        deviation: How far the smooth path leaves the polyline, by the measure of the deviation
            bound [m], or the largest joint difference [rad | m] without one.
        added_duration: What keeping the limits between the points too has cost, against the
            first profile, which keeps them at the points only [s]; slightly below 0 where a finer grid
            has gained more.
        passes: How many times the profile was computed.
        binding: Kind of limit (velocity, acceleration, torque, jerk, tool speed) -> part of the duration
            for which it decides how fast the motion is; for the rest, no single limit decides.
    """

    trajectory: Trajectory
    deviation: float
    added_duration: float
    passes: int
    binding: Mapping[str, float]

    def __repr__(self) -> str:
        """Say the duration, and which limits decide it."""
        shares = ", ".join(f"{name} {share:.0%}" for name, share in self.binding.items())
        return f"Retimed({self.trajectory.duration:.3f} s, limited by {shares or 'none'})"


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
