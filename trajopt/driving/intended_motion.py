"""The intended motion to a goal, at a share of its planned speed.

The rate of the motion's clock changes smoothly (`trajopt.timing.time_scaling`), in the shortest of some times
with which the limits hold.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import ceil

import numpy as np

from trajopt.driving.motion_guard import MotionGuard
from trajopt.planning.result import Plan
from trajopt.problem.problem import PathConstraint, Problem
from trajopt.problem.requirement import During
from trajopt.robot.joints import JointLimits
from trajopt.timing.time_scaling import RateChange, StopsAlong, TimeScaling, holds_limits
from trajopt.values.arrays import Floats, Value
from trajopt.values.trajectory import Trajectory

SPEED_SCALINGS = (1.0, 0.8, 0.5, 0.25)
"""Shares of the planned speed. At a quarter a stop takes at most a quarter of the time."""
CHANGE_TIMES = (0.05, 0.1, 0.2, 0.4, 0.8)
"""Times that a change of speed may take [s]: from a stop of a light arm to a stop of a heavy one."""
STEP = 0.01
"""Time between points that a change adds [s]: quintics between them are near enough to the path."""
SMALLEST_STEP = 2e-4
"""Least time between points [s]: between closer ones rounding would act as a jerk."""
SAMPLES = 400
"""Samples of a change, for the inverse of its clock."""

NEAREST_SAMPLES = 400
"""Samples of a motion among which the one nearest to a rest is searched."""
NEWTON_STEPS = 8
"""Steps that refine its time to rounding: each squares the error."""


@dataclass(frozen=True)
class SpeedScaling(Value):
    """The clock of a motion whose rate changes once."""

    start: float
    change: RateChange

    @property
    def speed(self) -> float:
        return self.change.after

    def at(self, time: float) -> tuple[float, float, float]:
        """Return the time of the motion [s], the rate and its slope [1/s] at a time [s]."""
        clock, rate, slope = self.rows(np.array((time,)))[:, 0].tolist()
        return clock, rate, slope

    def rows(self, times: Floats) -> Floats:
        duration = self.change.duration
        after = np.maximum(times - duration, 0.0)
        share = np.minimum(times, duration) / duration if duration else np.ones_like(times)
        clock, rate, slope, _ = self.change.at(share)
        slope = np.where(after > 0.0, 0.0, slope)
        return np.stack((self.start + clock + after * self.speed, rate, slope))


FULL_SPEED = SpeedScaling(0.0, RateChange(1.0, 1.0, 0.0))


def scale_speed(
    planned: Trajectory, begin: tuple[float, float, float], speed: float, limits: JointLimits
) -> tuple[Trajectory, SpeedScaling] | None:
    """Return the rest of a motion at another speed; None if every change of speed breaks a limit."""
    start, rate, slope = begin
    if start > planned.duration - STEP:
        return None
    if rate == speed and slope == 0.0:
        scaling = SpeedScaling(start, RateChange(rate, speed, 0.0))
        return _scaled(planned, scaling), scaling
    for duration in CHANGE_TIMES:
        scaling = SpeedScaling(start, RateChange(rate, speed, duration, slope))
        clock, rates, _ = scaling.rows(np.linspace(0.0, duration, SAMPLES + 1))
        if clock[-1] > planned.duration - STEP:
            return None
        if (rates[1:] <= 0.0).any():
            continue
        motion = _scaled(planned, scaling)
        if holds_limits(motion, limits):
            return motion, scaling
    return None


def _scaled(planned: Trajectory, scaling: SpeedScaling) -> Trajectory:
    duration = scaling.change.duration
    points = planned.times[planned.times > scaling.start]
    points[-1] = planned.duration
    samples = np.linspace(0.0, duration, SAMPLES + 1)
    reached = scaling.rows(samples)[0]
    at = duration + (points - reached[-1]) / scaling.speed
    if duration:
        at = np.where(points > reached[-1], at, np.interp(points, reached, samples))
    even = np.linspace(0.0, duration, 1 + ceil(duration / STEP))
    separate = np.abs(at[:-1, None] - even).min(axis=1) > SMALLEST_STEP
    times = np.sort(np.concatenate((even, at[:-1][separate], at[-1:])))
    clock, rate, slope = scaling.rows(times)
    clock[-1] = planned.duration
    return TimeScaling(times, clock, rate, slope).applied_to(planned)


@dataclass(frozen=True, eq=False)
class GuardedGoal(Value):
    """A goal of a supervisor, at whose end the tool may be passed within a blend radius [m]."""

    problem: Problem
    guard: MotionGuard
    blend_radius: float = 0.0

    def beyond(self, passed: Collection[str]) -> "GuardedGoal":
        """Return the goal without waypoints, and without the requirements up to them."""
        problem = self.problem
        ways = zip(problem.waypoint_names, problem.waypoint_requirements, strict=True)
        constraints: list[PathConstraint | During[PathConstraint]] = []
        for item in problem.constraints:
            if not isinstance(item, During) or (item.after not in passed and item.until not in passed):
                constraints.append(item)
            elif item.until is None:
                constraints.append(item.required)
            elif item.until not in passed:
                constraints.append(replace(item, after=None))
        left = {name: wanted for name, wanted in ways if name not in passed}
        return replace(self, problem=replace(problem, waypoints=left, constraints=constraints, knots=0))


@dataclass(frozen=True, eq=False, kw_only=True)
class IntendedMotion(Value):
    """The whole motion to a goal, of which a piece at a time is committed.

    Attributes:
        held_back: Whether it waits or slows down for a dynamic obstacle.
        passes: Waypoint -> when the planned motion passes it [s].
    """

    goal: GuardedGoal
    planned: Trajectory
    trajectory: Trajectory
    scaling: SpeedScaling
    begin: float
    held_back: bool = False
    passes: Mapping[str, float] = field(default_factory=dict[str, float])

    @staticmethod
    def of(goal: GuardedGoal, plan: Plan, begin: float) -> "IntendedMotion":
        planned, ways = plan.trajectory, plan.problem.waypoint_names
        # The certificate measures every margin: in the middle of a run only if it is needed.
        passes = {name: plan.certificate.passing_time(name) or 0.0 for name in ways}
        return IntendedMotion(
            goal=goal, planned=planned, trajectory=planned, scaling=FULL_SPEED, begin=begin, passes=passes
        )

    def retimed(self, trajectory: Trajectory, begin: float) -> "IntendedMotion":
        """Return the rest of the motion with another timing."""
        passed = self.passed(begin - self.begin)
        passes = {
            name: time_at(trajectory, self.planned(time), 0.0, trajectory.duration)
            for name, time in self.passes.items()
            if name not in passed
        }
        return replace(
            self,
            planned=trajectory,
            trajectory=trajectory,
            scaling=FULL_SPEED,
            begin=begin,
            held_back=True,
            passes=passes,
        )

    @property
    def end(self) -> float:
        """When it ends, on the executor's clock [s]."""
        return self.begin + self.trajectory.duration

    @cached_property
    def stops(self) -> StopsAlong:
        return StopsAlong(self.trajectory, self.goal.problem.limits)

    def passed(self, time: float) -> frozenset[str]:
        clock, _, _ = self.scaling.at(time)
        return frozenset(name for name, passing in self.passes.items() if passing <= clock)

    def after(self, time: float) -> Trajectory:
        return self.trajectory.between(max(time - self.begin, 0.0), self.trajectory.duration)

    def at_speed(
        self, speed: float, time: float, *, rests_at: float | None = None
    ) -> "IntendedMotion | None":
        clock, rate, slope = self.scaling.at(time - self.begin if rests_at is None else rests_at)
        begin = (clock, rate, slope) if rests_at is None else (clock, 0.0, 0.0)
        found = scale_speed(self.planned, begin, speed, self.goal.problem.limits)
        if found is None:
            return None
        trajectory, scaling = found
        return replace(self, trajectory=trajectory, scaling=scaling, begin=time)


def time_at(motion: Trajectory, positions: Floats, after: float, before: float) -> float:
    times = np.linspace(after, min(before, motion.duration), NEAREST_SAMPLES + 1)
    time = float(times[np.linalg.norm(motion(times) - positions, axis=1).argmin()])
    for _ in range(NEWTON_STEPS):
        velocity = motion(time, 1)
        speed = float(velocity @ velocity)
        if speed > 0.0:
            time += float(velocity @ (positions - motion(time))) / speed
            time = min(max(time, after), motion.duration)
    return time
