"""Requirement that a frame follows a curve from its beginning."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from trajopt.problem.requirement import MILLIMETRES, Relaxation, Requirement
from trajopt.values.arrays import Floats, direction_of, floats, number, one_of, positive
from trajopt.values.curve import Curve
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked
from trajopt.values.likely_units import stated_angle, warn_of_wide_tolerance
from trajopt.values.placement import WORLD
from trajopt.values.printed import in_axis, in_degrees, in_length, in_point

CURVE_POSITION = 1e-4
"""Default distance from the curve [m]."""
CURVE_ROTATION = float(np.radians(0.1))
"""Default angle from the curve's orientation [rad]."""


@dataclass(frozen=True, eq=False)
class FollowsCurve(Requirement):
    """A point of a frame follows a curve from its beginning up to a length along it, never backwards.

    At each time t the frame is within the tolerances of a location s(t) of the curve, and s never decreases.

    Fields: arguments of `follows_curve`.
    """

    frame: str
    curve: Curve
    position_tolerance: float
    rotation_tolerance: float
    until: float
    spin: Floats | None
    reference: str
    offset: Floats

    @property
    def fraction(self) -> float:
        """Required share of the curve."""
        return self.until / self.curve.length

    @checked
    def after(self, s: float) -> FollowsCurve:
        """Return the requirement of the part after a length along the curve [m]."""
        return replace(self, curve=self.curve.after(s), until=self.until - s)

    @property
    def units(self) -> tuple[str, ...]:
        return ("m", "rad") if np.isfinite(self.rotation_tolerance) else ("m",)

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        return (
            self.relaxed("position_tolerance", f"distance of {self.frame} from its curve", 1.0, MILLIMETRES),
        )

    def __str__(self) -> str:
        first, last = (in_point(self.curve.placement(s).translation) for s in (0.0, self.curve.length))
        part = "" if self.fraction == 1.0 else f"the first {in_length(self.until)} of "
        curve = f"{part}a curve of {in_length(self.curve.length)} from {first} to {last}"
        seen = "" if self.reference == WORLD else f" in {self.reference}"
        turned = f" and {in_degrees(self.rotation_tolerance)}" if np.isfinite(self.rotation_tolerance) else ""
        spin = "" if self.spin is None else f", free about {in_axis(self.spin)}"
        within = f"within {in_length(self.position_tolerance)}{turned}{spin}"
        return f"{self.frame} along {curve}{seen}, {within}"


@checked
def follows_curve(
    frame: str,
    curve: Curve,
    *,
    position_tolerance: float = CURVE_POSITION,
    rotation_tolerance: float | None = None,
    until: float | None = None,
    spin: ArrayLike | None = None,
    reference: str = WORLD,
    offset: ArrayLike = (0.0, 0.0, 0.0),
    degrees: bool = False,
) -> FollowsCurve:
    """Require a frame to follow a curve from its beginning, never backwards, at all times.

    Args:
        frame: Link, tool frame or attached object.
        curve: Curve in `reference`.
        position_tolerance: Largest distance from the location on the curve [m].
        rotation_tolerance: Largest angle from the orientation there [rad]; inf for any, 0.1 deg by default.
        until: Length to follow [m]; the whole curve by default.
        spin: Axis in the frame about which it may turn freely; none by default.
        reference: "world", or the frame in which the curve is given.
        offset: Point that follows, in the frame's coordinates, shape (3,) [m].
        degrees: Whether the rotation tolerance is in degrees.

    Raises:
        ShapeError: If a number is not usable.
        ProblemError: If a tolerance is not positive or the length is not on the curve.

    Warns:
        UnitWarning: If the position tolerance is two metres or more.
    """
    way = one_of("curve", curve, Curve)
    end = way.length if until is None else number("until", until)
    if not 0.0 <= end <= way.length:
        raise ProblemError(f"until must lie on the curve, in [0, {way.length:.6g}] m, is {end:g} m")
    turned = stated_angle(
        "rotation_tolerance", rotation_tolerance, degrees=degrees, default=CURVE_ROTATION, infinite=True
    )
    held = positive("position_tolerance", position_tolerance)
    warn_of_wide_tolerance("position_tolerance", held)
    return FollowsCurve(
        frame,
        way,
        held,
        positive("rotation_tolerance", turned, infinite=True),
        end,
        None if spin is None else direction_of("spin", spin),
        reference,
        floats("offset", offset, (3,)),
    )
