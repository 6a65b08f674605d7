"""Timing within all limits of a problem."""

from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from itertools import pairwise

import numpy as np

from trajopt.geometry import Evaluator, angular_jacobian, point_jacobian
from trajopt.optimise.transcription.free_duration import SHORTEST
from trajopt.problem.problem import Problem
from trajopt.problem.tool_speed import ToolSpeed
from trajopt.robot.joints import JointLimits
from trajopt.timing import Retimed, RetimeFailure, RetimeOptions, SpeedOfTools, ToolLimits, retime
from trajopt.timing.time_scaling import in_turn, stop_from
from trajopt.values.arrays import Floats, readonly
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Path, Trajectory

PATH_TOLERANCE = 5e-3
"""Default of the largest distance of a timed motion from its path [m]."""


@checked
def retime_path(
    problem: Problem,
    path: Path,
    *,
    through: Sequence[int] = (),
    tolerance: float = PATH_TOLERANCE,
    query: Evaluator | None = None,
    limits: JointLimits | None = None,
) -> Retimed | RetimeFailure:
    """Find the fastest trajectory along a path within every limit of a problem, from rest to rest.

    Limits are the joints' velocity, acceleration, jerk and torque (with the payload), scaled by the problem,
    and its tool speeds.

    Args:
        through: Knots that the motion passes through although corners are rounded.
        tolerance: Largest distance of any point of the robot from the path at rounded corners [m].

    Raises:
        FrameNotFound: If a tool speed names an unknown frame.
        ShapeError: If the path is of other joints, or `through` names no inner knot.
    """
    limits, reduced = limits or problem.limits, problem.reduced
    query = query or problem.evaluator(reduced)
    limited = np.isfinite(limits.effort).any()
    return retime(
        path,
        limits,
        through=through,
        inverse_dynamics=query.dynamics.torque if limited else None,
        tools=tool_limits(query, problem.tool_speeds),
        deviation=query.displacement,
        options=replace(RetimeOptions(), path_tolerance=tolerance),
    )


def retime_with_stops(
    problem: Problem, path: Path, stops: Sequence[int], *, tolerance: float, query: Evaluator
) -> Retimed | RetimeFailure:
    """Find the fastest trajectory along a path that comes to rest at some of its knots.

    Args:
        stops: Knots between the first and the last, increasing.
        tolerance: Largest distance of any point of the robot from the path at rounded corners [m].
    """
    legs: list[Retimed] = []
    for first, last in pairwise((0, *stops, len(path.knots) - 1)):
        leg = replace(path, knots=path.knots[first : last + 1])
        timed = retime_path(problem, leg, tolerance=tolerance, query=query)
        if isinstance(timed, RetimeFailure):
            return timed
        legs.append(timed)
    trajectory = reduce(in_turn, (leg.trajectory for leg in legs))
    kinds = {kind for leg in legs for kind in leg.binding}
    lasts = [leg.trajectory.duration for leg in legs]
    return Retimed(
        trajectory,
        max(leg.deviation for leg in legs),
        sum(leg.added_duration for leg in legs),
        sum(leg.passes for leg in legs),
        {
            kind: sum(leg.binding.get(kind, 0.0) * last for leg, last in zip(legs, lasts, strict=True))
            / sum(lasts)
            for kind in sorted(kinds)
        },
    )


def tool_limits(query: Evaluator, limited: Sequence[ToolSpeed]) -> ToolLimits | None:
    """Return the limited speeds of tools for retiming; None if there are none.

    Raises:
        FrameNotFound: If a frame is unknown.
    """
    if not limited:
        return None
    kept = [(tool, which) for tool in limited for which in (0, 1) if np.isfinite(_limits(tool)[which])]
    return ToolLimits(
        _speeds(query, limited),
        np.array([_limits(tool)[which] for tool, which in kept]),
        tuple(f"{('speed', 'turning')[which]} of {tool.frame}" for tool, which in kept),
    )


def _limits(tool: ToolSpeed) -> tuple[float, float]:
    return tool.linear, tool.angular


def _speeds(query: Evaluator, limited: Sequence[ToolSpeed]) -> SpeedOfTools:
    places = [(tool, *query.reduced.attachment(tool.frame)) for tool in limited]

    def speeds(q: Floats, v: Floats) -> Floats:
        kinematics = query.kinematics(q)
        columns: list[Floats] = []
        for tool, joint, place in places:
            if np.isfinite(tool.linear):
                point = (
                    kinematics.rotation[:, joint] @ (place * tool.offset) + kinematics.translation[:, joint]
                )
                carriers = np.full(len(q), joint, dtype=np.int64)
                jacobian = point_jacobian(query.reduced, kinematics.jacobian, carriers, point)
                columns.append(np.linalg.norm(np.einsum("sij,sj->si", jacobian, v), axis=1))
            if np.isfinite(tool.angular):
                jacobian = angular_jacobian(query.reduced, kinematics.jacobian, joint)
                columns.append(np.linalg.norm(np.einsum("sij,sj->si", jacobian, v), axis=1))
        return np.stack(columns, axis=1)

    return speeds


@checked
def stopping_motion(problem: Problem) -> Trajectory:
    """Return a motion that brings a start in motion to rest as soon as the limits allow.

    It has three pieces of constant jerk: rising, constant and falling deceleration. All joints brake
    together, so that the arm nearly keeps its direction; if that takes a joint out of its limits, each brakes
    by itself.
    """
    begin = np.stack((problem.reduced.start_positions, problem.start_velocities, problem.start_accelerations))
    return stop_from(begin, with_jerk(problem.limits))


def with_jerk(limits: JointLimits) -> JointLimits:
    """Return limits with finite jerk for every joint, so that acceleration is continuous after a stop.

    By default the acceleration rises within the shortest duration of a motion.
    """
    return replace(limits, jerk=readonly(np.minimum(limits.jerk, limits.acceleration / SHORTEST)))
