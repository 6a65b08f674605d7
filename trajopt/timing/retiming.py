"""Time-optimal path parametrisation under velocity, acceleration, jerk, torque and tool-speed limits."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from trajopt.native import timing
from trajopt.robot.joints import JointLimits
from trajopt.timing.refusal import ROOM, STILL, endless, immovable, untimed
from trajopt.timing.result import (
    DeviationBound,
    InverseDynamics,
    Retimed,
    RetimeFailure,
    RetimeOptions,
    ToolLimits,
)
from trajopt.values.arrays import Floats, Ints
from trajopt.values.errors import ShapeError
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import LONGEST, Path, Trajectory

DEFAULT_OPTIONS = RetimeOptions()
"""Default options of `retime`."""
KINDS = ("velocity", "tool speed", "acceleration", "torque", "jerk")
"""Kinds of limits, in the order of the core's `Kind`."""


@checked
def retime(
    path: Path,
    limits: JointLimits,
    *,
    through: Sequence[int] = (),
    inverse_dynamics: InverseDynamics | None = None,
    tools: ToolLimits | None = None,
    deviation: DeviationBound | None = None,
    options: RetimeOptions = DEFAULT_OPTIONS,
) -> Retimed | RetimeFailure:
    """Smooth a path and compute the fastest trajectory along it, from rest to rest.

    Velocity, acceleration and jerk limits hold at all times (by the extremes of the polynomials); torque and
    tool-speed limits hold at the points and at dense samples between them.

    Args:
        path: Polyline; repeated knots and a path of length zero are allowed.
        limits: Joint limits; `JointLimits.scaled` makes motions slower. Jerks are limited if a joint that
            moves has a jerk limit.
        through: Indices of inner knots that the smooth path passes through: their corners are moved outwards,
            within the tolerance.
        inverse_dynamics: Joint torques at positions, velocities and accelerations; without it effort limits
            are ignored. An infinite effort limit does not count.
        tools: Limited tool speeds.
        deviation: Bound on the travel of any body point between a position on the smooth path and one on the
            polyline [m]; default: the largest joint difference [rad | m].
        options: Tolerance of the smooth path, number of points and passes.

    Returns:
        The trajectory, or the reason why none exists.

    Raises:
        ShapeError: If limits and path have different joints, `through` contains no inner knot, a velocity or
            acceleration limit is not finite, a function returns a wrong shape or a number that is not finite,
            or the distances of knots overflow.
    """
    _check(path, limits, through)
    failure = endless(path.knots, limits)
    if failure is not None:
        return failure
    if float(np.abs(path.knots - path.knots[0]).max()) <= STILL:
        return Retimed(_standing(path, options.shortest), 0.0, 0.0, 0, {})
    failure = immovable(path.knots, limits)
    if failure is not None:
        return failure

    def along(knots: Floats) -> timing.Retimed:
        return timed(
            replace(path, knots=knots),
            limits,
            inverse_dynamics=inverse_dynamics,
            tools=tools,
            deviation=deviation,
            options=options,
        )

    found = timed_through(path.knots, np.array(through, dtype=np.int64), limits, along)
    failure = untimed(found, limits)
    if failure is not None:
        return failure
    trajectory = Trajectory(
        path.joint_names, found.times, found.positions, found.velocities, found.accelerations
    )
    parts = sorted(zip(KINDS, found.binding, strict=True), key=lambda item: -item[1])
    binding = {kind: part for kind, part in parts if part > 0.0}
    return Retimed(trajectory, found.deviation, found.added, found.passes, binding)


def timed(
    path: Path,
    limits: JointLimits,
    *,
    inverse_dynamics: InverseDynamics | None,
    tools: ToolLimits | None,
    deviation: DeviationBound | None,
    options: RetimeOptions,
) -> timing.Retimed:
    """Time a path that moves, by the native core; arguments as in `retime`."""
    return timing.retime(
        path.knots,
        positions=(limits.lower, limits.upper),
        limits=(limits.velocity, limits.acceleration, limits.jerk, limits.effort),
        inverse_dynamics=inverse_dynamics,
        tools=np.empty(0) if tools is None else tools.limit,
        speeds=None if tools is None else tools.speeds,
        deviation=deviation,
        tolerance=options.path_tolerance,
        points=options.points,
        passes=options.passes,
        remainder=options.remainder,
        shortest=options.shortest,
        longest=ROOM * LONGEST,
    )


def _check(path: Path, limits: JointLimits, through: Sequence[int]) -> None:
    if limits.joint_names != path.joint_names:
        raise ShapeError("limits", f"are of {limits.joint_names}, the path is of {path.joint_names}")
    for name, limit in (("velocity", limits.velocity), ("acceleration", limits.acceleration)):
        if not np.isfinite(limit).all():
            raise ShapeError(f"limits.{name}", f"must be finite, else time would vanish: {limit.tolist()}")
    inner = len(path.knots) - 2
    outside = [knot for knot in through if not 1 <= knot <= inner]
    if outside:
        raise ShapeError("through", f"must be knots between 1 and {inner}, not {outside}")


def _standing(path: Path, duration: float) -> Trajectory:
    """Return a trajectory at rest (which covers a remaining distance of up to 1e-12 rad)."""
    still = np.zeros((2, len(path.joint_names)))
    return Trajectory(path.joint_names, np.array((0.0, duration)), path.knots[[0, -1]], still, still.copy())


NEAR_ENOUGH = 1e-7
"""Joint distance within which a knot is passed, below the resolution of controllers [rad | m]."""
ROUNDS = 8
"""Most rounds of moving corners. Each round leaves about a third of the error: the spline passes a corner
within a third of its shorter leg and cuts off the same share of the corner's displacement.
"""
DEGREE = 3
"""Degree of the smooth path."""


def timed_through(
    knots: Floats, through: Ints, limits: JointLimits, time_path: Callable[[Floats], timing.Retimed]
) -> timing.Retimed:
    """Time a polyline so that the smooth path passes through some of its knots.

    Args:
        knots: Polyline, shape (N, n) [rad | m].
        through: Indices of the knots to pass, shape (w,).
        limits: Joint limits: velocities scale the path parameter, positions bound the corners.

    Returns:
        The timing with the smallest largest joint distance from the knots, or a failed one.
    """
    corners, nearest, least = knots, time_path(knots), np.inf
    found = nearest
    for _ in range(ROUNDS if len(through) else 0):
        if found.outcome is not timing.Outcome.TIMED:
            break
        missed = knots[through] - _passed(found, corners, through, limits)
        worst = float(np.abs(missed).max())
        if worst < least:
            nearest, least = found, worst
        if worst <= NEAR_ENOUGH:
            break
        corners = corners.copy()
        corners[through] = np.clip(corners[through] + missed, limits.lower, limits.upper)
        found = time_path(corners)
    return nearest


def _passed(found: timing.Retimed, corners: Floats, through: Ints, limits: JointLimits) -> Floats:
    """Return the points of the smooth path at the corners' parameters, shape (w, n)."""
    from scipy.interpolate import BSpline

    speed = np.where(np.isfinite(limits.velocity) & (limits.velocity > 0.0), limits.velocity, 1.0)
    steps = np.linalg.norm(np.diff(corners, axis=0) / speed, axis=1)
    parameters = np.concatenate(([0.0], np.cumsum(steps)))[through]
    ends = np.repeat(found.knots[[0, -1]], DEGREE).reshape(2, DEGREE)
    spline = BSpline(np.concatenate((ends[0], found.knots, ends[1])), found.control, DEGREE)
    relative: Floats = spline(np.clip(parameters, 0.0, found.knots[-1]))
    return corners[0] + relative
