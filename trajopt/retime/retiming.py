"""From a path to a trajectory: time-optimal along it under velocity, acceleration and torque limits."""

import numpy as np

from trajopt.errors import ShapeError
from trajopt.model.limits import JointLimits
from trajopt.model.trajectory import Path, Trajectory
from trajopt.retime.constraints import InverseDynamics, ToolLimits, TorqueLimits
from trajopt.retime.refusal import STILL, endless, immovable
from trajopt.retime.result import Retimed, RetimeFailure, RetimeOptions
from trajopt.retime.smoothing import DeviationBound, polyline, smooth
from trajopt.retime.timing import fastest_trajectory

DEFAULT_OPTIONS = RetimeOptions()
"""The default options of `retime`."""


def retime(
    path: Path,
    limits: JointLimits,
    *,
    inverse_dynamics: InverseDynamics | None = None,
    tools: ToolLimits | None = None,
    deviation: DeviationBound | None = None,
    options: RetimeOptions = DEFAULT_OPTIONS,
) -> Retimed | RetimeFailure:
    """Make a path smooth and find the fastest trajectory along it, from rest to rest.

    The trajectory holds the velocity, acceleration and jerk limits at all times (the extremes of its
    polynomials are computed), and the limits of torques and tools at its points and densely between.

    Args:
        path: A polyline; it may have repeated knots, or go nowhere at all.
        limits: Limits of its joints; `JointLimits.scaled` makes motions slower.
            Where a joint that moves has a jerk limit, jerks are limited.
        inverse_dynamics: Torques of the joints at positions, velocities and accelerations; without
            it effort limits are not used. Joints with infinite effort limits have none.
        tools: Limited speeds of tools.
        deviation: Bound on how far any body point moves between a position of the smooth path and
            one of the polyline [m]; without it, the largest joint difference counts [rad | m].
        options: Tolerance of the smooth path, number of points and of passes.

    Returns:
        The trajectory, or the reason why there is none.

    Raises:
        ShapeError: If the limits are of other joints than the path, or a velocity or
            acceleration limit or a deviation is not finite.
    """
    _check(path, limits)
    failure = endless(path.knots, limits)
    if failure is not None:
        return failure
    line = polyline(path.knots, limits.velocity)
    torque = _torque_limits(limits, inverse_dynamics)
    if float(np.abs(line.corners).max()) <= STILL:
        return Retimed(_standing(path, options.shortest), 0.0, 0.0, 0, {})
    failure = immovable(line, limits)
    if failure is not None:
        return failure
    smoothing = smooth(
        line,
        lower=limits.lower,
        upper=limits.upper,
        deviation=deviation,
        tolerance=options.path_tolerance,
    )
    timed, _ = fastest_trajectory(smoothing, limits, options=options, torque=torque, tools=tools)
    return timed


def _check(path: Path, limits: JointLimits) -> None:
    if limits.joint_names != path.joint_names:
        raise ShapeError("limits", f"are of {limits.joint_names}, the path is of {path.joint_names}")
    for name, limit in (("velocity", limits.velocity), ("acceleration", limits.acceleration)):
        if not np.isfinite(limit).all():
            raise ShapeError(f"limits.{name}", f"must be finite, else time would vanish: {limit.tolist()}")


def _torque_limits(limits: JointLimits, inverse_dynamics: InverseDynamics | None) -> TorqueLimits | None:
    limited = np.nonzero(np.isfinite(limits.effort))[0]
    if inverse_dynamics is None or not len(limited):
        return None
    return TorqueLimits(inverse_dynamics, limited, limits.effort[limited])


def _standing(path: Path, duration: float) -> Trajectory:
    """Stay at the start for a moment (and move the last 1e-12 rad to the goal)."""
    still = np.zeros((2, len(path.joint_names)))
    return Trajectory(path.joint_names, np.array((0.0, duration)), path.knots[[0, -1]], still, still.copy())
