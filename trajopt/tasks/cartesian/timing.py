"""Timing of a joint path along a curve: retiming within the tool's tolerance, with stops in sharp corners.

A tool that keeps to a tenth of a millimetre passes a sharp corner so slowly that rest costs little more;
mild ones are rounded. A blend radius makes corners fast.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from trajopt.optimise.methods.timing import tool_limits
from trajopt.problem.problem import Problem
from trajopt.tasks.cartesian.on_curve import OnCurve
from trajopt.timing import Retimed, RetimeFailure, RetimeOptions, retime
from trajopt.values.arrays import Floats, readonly
from trajopt.values.trajectory import Path, Trajectory

BODIES = 0.1
"""The rest of the arm may leave its path ten times as far as the tool."""
POINTS_PER_KNOT = 0.7
"""Points of the motion per knot of the path, beyond the usual number."""
MOST_POINTS = 600
"""Points of the motion at most."""
SHARP = np.radians(25.0)
"""At corners of the joint path that turn by more the motion stops [rad]."""
DWELL = 2e-3
"""Time in which an acceleration changes that has no limit on its jerk, at rest in a corner [s]."""


def timed_along(
    problem: Problem, on_curve: OnCurve, path: Path, *, tolerance: float
) -> Retimed | RetimeFailure:
    """Find the fastest timing of a path, within everything that the problem limits.

    Args:
        problem: The problem.
        on_curve: Measures how far the tool is from where it should be.
        path: The joint path.
        tolerance: How far the tool may leave it, rotations counted as lengths [m].
    """
    query, limits = on_curve.query, problem.limits

    def deviation(smooth: Floats, straight: Floats) -> Floats:
        return np.maximum(on_curve.apart(smooth, straight), BODIES * query.displacement(smooth, straight))

    corners = _corners(path.knots, limits.velocity)
    legs: list[Retimed] = []
    for first, last in pairwise((0, *corners, len(path.knots) - 1)):
        leg = Path(path.joint_names, path.knots[first : last + 1])
        usual = RetimeOptions()
        points = int(np.clip(POINTS_PER_KNOT * len(leg.knots), usual.points, MOST_POINTS))
        found = retime(
            leg,
            limits,
            inverse_dynamics=query.dynamics.torque if np.isfinite(limits.effort).any() else None,
            tools=tool_limits(query, problem.tool_speeds),
            deviation=deviation,
            options=replace(usual, path_tolerance=tolerance, points=points),
        )
        if isinstance(found, RetimeFailure):
            place = (first + found.place * (last - first)) / (len(path.knots) - 1)
            return replace(found, place=place)
        legs.append(found)
    return legs[0] if len(legs) == 1 else _together(legs)


def _corners(knots: Floats, velocity: Floats) -> tuple[int, ...]:
    """Find the knots at which the path turns sharply, in joints over their speeds."""
    steps = np.diff(knots, axis=0) / np.where(velocity > 0.0, velocity, 1.0)
    sizes = np.linalg.norm(steps, axis=1)
    along = (steps[:-1] * steps[1:]).sum(axis=1) / np.maximum(sizes[:-1] * sizes[1:], 1e-300)
    sharp = (along < np.cos(SHARP)) & (sizes[:-1] > 0.0) & (sizes[1:] > 0.0)
    return tuple((np.flatnonzero(sharp) + 1).tolist())


def _together(legs: Sequence[Retimed]) -> Retimed:
    """Join motions that begin and end at rest, one after the other."""
    duration = sum(leg.trajectory.duration for leg in legs)
    kinds = {kind for leg in legs for kind in leg.binding}
    return Retimed(
        _joined([leg.trajectory for leg in legs]),
        max(leg.deviation for leg in legs),
        sum(leg.added_duration for leg in legs),
        sum(leg.passes for leg in legs),
        {
            kind: sum(leg.binding.get(kind, 0.0) * leg.trajectory.duration for leg in legs) / duration
            for kind in sorted(kinds)
        },
    )


def _joined(motions: Sequence[Trajectory]) -> Trajectory:
    """Join trajectories; where the acceleration would jump it changes within a moment of rest."""
    times, columns, clock = [motions[0].times], [_columns(motions[0])], motions[0].duration
    for motion in motions[1:]:
        rows = _columns(motion)
        same = np.array_equal(columns[-1][2][-1], rows[2][0])
        begin = clock if same else clock + DWELL
        skipped = 1 if same else 0
        times.append(begin + motion.times[skipped:])
        columns.append(rows[:, skipped:])
        clock = begin + motion.duration
    positions, velocities, accelerations = np.concatenate(columns, axis=1)
    return Trajectory(
        motions[0].joint_names,
        readonly(np.concatenate(times)),
        readonly(positions),
        readonly(velocities),
        readonly(accelerations),
    )


def _columns(motion: Trajectory) -> Floats:
    """Positions, velocities and accelerations of a retimed motion, shape (3, k, n)."""
    assert motion.velocities is not None
    assert motion.accelerations is not None
    return np.stack((motion.positions, motion.velocities, motion.accelerations))
