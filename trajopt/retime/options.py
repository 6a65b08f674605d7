"""What a caller may choose about retiming."""

from dataclasses import dataclass

from trajopt.errors import ShapeError

LEAST_TOLERANCE = 1e-7
"""Corners are never rounded more tightly than this [m | rad]."""


@dataclass(frozen=True)
class RetimeOptions:
    """Options of `retime`.

    Attributes:
        path_tolerance: How far the smooth path may leave the polyline, by the measure of the
            deviation bound [m]; without such a bound, by the largest joint difference [rad | m].
        points: Points of the trajectory that are asked for. Every knot of the smooth path is a
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
        """Refuse what cannot be meant.

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
