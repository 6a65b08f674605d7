"""Timing a smooth path: the fastest profile whose trajectory holds all limits at all times."""

from dataclasses import dataclass, replace

import numpy as np

from tests.oracles.retiming.attempt import Attempt, Timer
from tests.oracles.retiming.constraints import TorqueLimits, torque_along
from tests.oracles.retiming.discretised_path import (
    Bounds,
    DiscretisedPath,
    discretised,
    even_grid,
    fastest_profile,
    finer_grid,
    first_grid,
    turned,
)
from tests.oracles.retiming.jerk_program import NothingFits
from tests.oracles.retiming.jerk_timing import DEVIATION, JerkTimer, limited_jerk
from tests.oracles.retiming.peaks import path_deviation, tightened
from tests.oracles.retiming.refusal import ROOM, unholdable
from tests.oracles.retiming.smoothing import Smoothing
from trajopt.robot.joints import JointLimits
from trajopt.timing import ToolLimits
from trajopt.timing.retiming import Retimed, RetimeFailure, RetimeOptions
from trajopt.values.arrays import Floats, readonly
from trajopt.values.trajectory import LONGEST

STRICT = 1.0 - 1e-9
"""Part of each limit that a trajectory may use: rounding errors stay below what is left."""
FIRST_POINTS = 80
"""Intervals of the first grid, which only serves to lay the second."""
COARSE = 1.05
"""Pieces that would have to run slower by more than this factor are cut in two."""
TOOL_ROOM = 1e-3
"""Part of each tool's limit that is left free, so that the judge need not sample every millisecond to prove
that the limit holds."""
REFINEMENTS = 3
"""How often the grid is refined; a limit that is still exceeded then is not due to the grid."""


@dataclass(frozen=True, eq=False)
class PathTimer(Timer):
    """Finds the fastest timing of a path from rest to rest, without limits on the jerk."""

    def run(self, on: DiscretisedPath) -> tuple[Retimed | RetimeFailure, Floats]:
        """Find the fastest trajectory, refining the grid, and slow it down by what remains.

        Args:
            on: The path on a grid that is even in time.

        Returns:
            The result, and the path parameter of each of its points.
        """
        first = self._attempt(on, on.bounds, refinable=True)
        best, passes = self._improved(first)
        first_duration = max(first.profile.duration, self.options.shortest)
        return self.finish(best, first_duration, passes), best.on.s

    def discretised(self, s: Floats) -> DiscretisedPath:
        """Evaluate the path and its limits on a grid, shape (k,)."""
        return discretised(self.smoothing.path, s, self.limits, torque=self.along, tools=self.tools)

    def _attempt(self, on: DiscretisedPath, bounds: Bounds, *, refinable: bool) -> Attempt:
        profile = fastest_profile(on, bounds)
        attempt = self.measure(on, bounds, profile, self.options.remainder)
        deviation = path_deviation(self.smoothing.path, profile, attempt.trajectory)
        coarse = (attempt.slowdown.factors > COARSE) | (deviation > DEVIATION)
        again = attempt.slowdown.factor > 1.0 + self.options.remainder or (refinable and bool(coarse.any()))
        if not again:
            attempt = self.measure_torque(attempt)
            coarse |= attempt.slowdown.factors > COARSE
        return replace(attempt, coarse=coarse)

    def _improved(self, attempt: Attempt) -> tuple[Attempt, int]:
        """Remove what a trajectory exceeds between its points.

        Where that is much, or the path is left, the points are too far apart and the grid is
        refined; where it is little, the limits at the points are lowered.

        Returns:
            The attempt that is fastest when slowed down to hold all limits, and how many there were.
        """
        best, passes, refined = attempt, 1, 0
        while passes < self.options.passes:
            if attempt.coarse.any() and refined < REFINEMENTS:
                refined += 1
                finer = self.discretised(finer_grid(attempt.on.s, attempt.coarse))
                attempt = self._attempt(finer, finer.bounds, refinable=refined < REFINEMENTS)
            elif attempt.slowdown.factor > 1.0 + self.options.remainder:
                bounds = tightened(attempt.on, attempt.bounds, attempt.peaks)
                attempt = self._attempt(attempt.on, bounds, refinable=refined < REFINEMENTS)
            else:
                break
            best, passes = attempt if attempt.merit < best.merit else best, passes + 1
        return best, passes


def fastest_trajectory(
    smoothing: Smoothing,
    limits: JointLimits,
    *,
    options: RetimeOptions,
    torque: TorqueLimits | None = None,
    tools: ToolLimits | None = None,
) -> tuple[Retimed | RetimeFailure, Floats]:
    """Find the fastest timing of a path from rest to rest.

    Args:
        smoothing: The smooth path, of positive length.
        limits: Velocity, acceleration and jerk limits.
        options: Number of points and passes.
        torque: Torque limits, if there are any.
        tools: Limited speeds of tools, if there are any.

    Returns:
        The result, and the path parameter of each point of its trajectory, shape (k,).
    """
    limits = replace(
        limits,
        velocity=readonly(limits.velocity * STRICT),
        acceleration=readonly(limits.acceleration * STRICT),
        jerk=readonly(limits.jerk * STRICT),
    )
    torque = None if torque is None else replace(torque, limit=torque.limit * STRICT)
    tools = None if tools is None else replace(tools, limit=tools.limit * (1.0 - TOOL_ROOM))
    path = smoothing.path
    along = None if torque is None else torque_along(path, torque)
    timer = PathTimer(smoothing, limits, torque, along, tools, options)
    rough = timer.discretised(first_grid(path.knots, FIRST_POINTS))
    failure = unholdable(rough, limits, torque)
    if failure is not None:
        return failure, rough.s
    profile = fastest_profile(rough, rough.bounds)
    if not profile.duration <= ROOM * LONGEST:
        reason = f"within all limits together it would take {profile.duration:.2g} s; "
        return RetimeFailure(reason + f"{ROOM * LONGEST:.2g} s are the most", None, 0.0), rough.s
    bends = turned(rough.s, rough.dq, rough.ddq, limits.velocity)
    fine = timer.discretised(even_grid(path.knots, profile, bends, options.points))
    failure = unholdable(fine, limits, torque)
    if failure is not None:
        return failure, fine.s
    if limited_jerk(limits, np.abs(fine.dq).max(axis=0)):
        jerk_timer = JerkTimer(smoothing, limits, torque, along, tools, options)
        try:
            return jerk_timer.run(fastest_profile(fine, fine.bounds))
        except NothingFits:
            return RetimeFailure("no speed along the path is within all limits", None, 0.0), fine.s
    return timer.run(fine)
