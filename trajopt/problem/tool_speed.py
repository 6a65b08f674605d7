"""ToolSpeed: limits on the linear and angular speed of a frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from trajopt.values.arrays import Floats, Value, floats, number, one_of
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.likely_units import stated_angle, warn_of_fast_limit
from trajopt.values.printed import in_degrees, in_length

SLOWEST = 1e-9
"""Smallest accepted limit; lower ones allow no motion of finite duration [m/s | rad/s]."""


@dataclass(frozen=True, eq=False)
class ToolSpeed(Value):
    """Largest speeds of a frame in the world.

    They depend on the timing of a path, not on its shape: retiming enforces them, and the judge measures the
    timed motion.

    Fields: arguments of `tool_speed`. Unset limits are infinite [m/s, rad/s].
    """

    GIVEN_AS: ClassVar[str] = "Problem(tool_speed=...), or GraspingOptions(tool_speed=...)"

    frame: str
    linear: float
    angular: float
    offset: Floats
    steady: float = np.inf

    def __str__(self) -> str:
        sizes = ((self.linear, in_length), (self.angular, in_degrees))
        limits = [f"{printed(limit)}/s" for limit, printed in sizes if np.isfinite(limit)]
        steady = f", steady within {100.0 * self.steady:.3g}%" if np.isfinite(self.steady) else ""
        return f"{self.frame} at most {' and '.join(limits)}{steady}"

    def __repr__(self) -> str:
        return f"ToolSpeed({self})"


@checked
def tool_speed(
    frame: str,
    *,
    linear: float = np.inf,
    angular: float = np.inf,
    offset: ArrayLike = (0.0, 0.0, 0.0),
    steady: float = np.inf,
    degrees: bool = False,
) -> ToolSpeed:
    """Limit the speed of a tool: `tool_speed("panda_hand_tcp", linear=0.25)`.

    The motion is the fastest along its path within all limits, so the tool moves at its limit unless a joint
    is slower; with `steady` the judge requires this.

    Args:
        linear: Largest speed of the point [m/s].
        angular: Largest angular speed of the frame [rad/s].
        offset: Point in the frame's coordinates, shape (3,) [m].
        steady: Largest relative drop of the speed below the linear limit between its ramps at both ends, in
            (0, 1); any by default.
        degrees: Whether the angular speed is in deg/s.

    Raises:
        ShapeError: If a number is not usable.
        ProblemError: If no limit is given, a limit is not positive or below 1e-9, or `steady` has no linear
            limit.

    Warns:
        UnitWarning: If a limit exceeds the speed of any arm.
    """
    one_of("frame", frame, str)
    turning = stated_angle(f"angular speed of {shown(frame)}", angular, degrees=degrees, infinite=True)
    limits = {"linear": linear, "angular": turning}
    for name, limit in limits.items():
        speed = number(f"{name} speed of {shown(frame)}", limit, infinite=True)
        if name == "linear" or not degrees:
            warn_of_fast_limit(
                f"{name} speed of {shown(frame)}", speed, "m/s" if name == "linear" else "rad/s"
            )
        if 0.0 < speed < SLOWEST:
            least = f"{SLOWEST:g} {'m/s' if name == 'linear' else 'rad/s'} is the least"
            raise ProblemError(f"tool_speed({shown(frame)}): the {name} limit is {limit:g}; {least}")
        if not speed > 0.0:
            raise ProblemError(f"tool_speed({shown(frame)}): the {name} limit must be positive, is {limit:g}")
    if np.isinf(list(limits.values())).all():
        raise ProblemError(f"tool_speed({shown(frame)}): give a linear limit, an angular one or both")
    if number(f"steady speed of {shown(frame)}", steady, infinite=True) != np.inf and (
        not 0.0 < steady < 1.0 or np.isinf(linear)
    ):
        raise ProblemError(
            f"tool_speed({shown(frame)}): steady is a drop in (0, 1) from a linear limit, "
            f"is {steady:g} from {linear:g}"
        )
    return ToolSpeed(frame, float(linear), turning, floats("offset", offset, (3,)), float(steady))
