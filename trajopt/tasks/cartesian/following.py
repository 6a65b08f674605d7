"""follow(...): a judged motion along a curve, as far as possible."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from itertools import pairwise
from threading import Event

import numpy as np

from trajopt.geometry import WorkCounts, evaluator
from trajopt.optimise.methods.timing import tool_limits
from trajopt.planning.budget import Budget, BudgetTracker, Progress, Stopped
from trajopt.planning.infeasibility import reasons
from trajopt.planning.plan import NO_BOUNDS
from trajopt.planning.result import Result
from trajopt.planning.search import ENDED
from trajopt.planning.status import Status
from trajopt.planning.workspace import MotionCandidate, PlanningWorkspace
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import FollowsCurve
from trajopt.problem.requirements.curves import CURVE_ROTATION
from trajopt.problem.tool_speed import ToolSpeed
from trajopt.robot.configuration import ConfigurationLike
from trajopt.scene.scene import Scene
from trajopt.tasks.cartesian.program import detours
from trajopt.tasks.cartesian.result import Followed, StopReason
from trajopt.tasks.cartesian.search import LEAST, CurveSearch, Found, beginning, beginnings, stop_reason
from trajopt.tasks.cartesian.tracking import CurveTrack, OnCurve, densified
from trajopt.timing import Retimed, RetimeFailure, RetimeOptions, retime
from trajopt.values.arrays import Floats, number, one_of, readonly, unless_none
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked
from trajopt.values.printed import in_degrees, in_length
from trajopt.values.trajectory import Path, Trajectory
from trajopt.verify import Judge, Moment


class Avoid(Enum):
    """Reaction to an obstacle on the curve."""

    STOP = "follow the curve as far as it goes"
    DEVIATE = "leave the curve inside a tube around it, no farther than needed"


class Begin(Enum):
    """Choice of the first configuration."""

    AT_START = "the start, which must be at the beginning of the curve"
    ANY_BRANCH = "any that is at the beginning of the curve: the one that gets farthest"


@checked
@dataclass(frozen=True, kw_only=True)
class FollowOptions:
    """Options of `follow`.

    Attributes:
        tube: With `Avoid.DEVIATE`, largest distance of the frame from the curve [m].
        velocity_scaling: Factor in (0, 1] on the velocity limits.
        acceleration_scaling: Factor in (0, 1] on the acceleration limits.
        tool_speed: Largest speeds of tools; constant if they request it.
        branches: With `Begin.ANY_BRANCH`, largest number of first configurations.
    """

    begin: Begin = Begin.AT_START
    avoid: Avoid = Avoid.STOP
    tube: float = 0.0
    velocity_scaling: float = 1.0
    acceleration_scaling: float = 1.0
    tool_speed: tuple[ToolSpeed, ...] = ()
    branches: int = 16

    def __post_init__(self) -> None:
        radius = number("tube", self.tube)
        if (self.avoid is Avoid.DEVIATE) != (radius > 0.0):
            raise ProblemError(
                f"a tube of {in_length(radius)} with {self.avoid}: Avoid.DEVIATE needs the radius of a tube "
                "to deviate in, Avoid.STOP has none"
            )
        if self.branches < 1:
            raise ProblemError(f"branches must be at least 1, is {self.branches}")


DEFAULT_OPTIONS = FollowOptions()
"""The default options of `follow`."""
START_SHARE = 0.5
"""Accepted deviation of the start from the curve, as a share of the tolerances."""
CHORDS = (0.2, 0.1, 0.05)
"""Distances of the chords between knots from the curve, as shares of the tolerance; the next is tried if the
judge refuses the motion.
"""
ROUNDINGS = (0.6, 0.4, 0.2)
"""Likewise for the deviation of the timed motion from these chords."""


def follow(
    scene: Scene,
    required: FollowsCurve,
    *,
    start: ConfigurationLike,
    group: str = "",
    options: FollowOptions = DEFAULT_OPTIONS,
    rng: np.random.Generator | None = None,
    budget: Budget = NO_BOUNDS,
    cancel: Event | None = None,
    progress: Progress | None = None,
    degrees: bool = False,
) -> Followed:
    """Follow a curve with a frame as far as possible.

    The motion is timed like any plan, and judged at all times: the frame stays on the curve, never moves
    backwards, and gets as far as `fraction`.

    Args:
        scene: Unlike other motions this one keeps the margin all along, except for pairs that are nearer at
            its start: a margin that is too large may end it.
        required: The curve, the frame, and its tolerance: `follows_curve(...)`.
        start: Name of a state, joint -> position [rad | m], or positions of all joints. With
            `Begin.ANY_BRANCH` it only determines the joints outside the group, and the preferred branch.
        group: Optional if the robot has only one.
        rng: Draws postures and starts of searches; a fixed seed if None.
        budget: Time and work; `attempts`, `workers` and `improve` do not apply.
        degrees: Whether angles in `start` are in degrees.

    Raises:
        ProblemError: If the curve does not suit this robot, or the budget has fields that do not apply.
        NameNotFound: If a frame, group or state is unknown.
    """
    required, options = one_of("required", required, FollowsCurve), one_of("options", options, FollowOptions)
    tracker = _tracker(budget, cancel, progress)
    problem = Problem(
        scene=one_of("scene", scene, Scene),
        group=group,
        start=start,
        goal=required,
        velocity_scaling=options.velocity_scaling,
        acceleration_scaling=options.acceleration_scaling,
        tool_speed=options.tool_speed,
        name="curve",
        degrees=degrees,
    )
    draws = unless_none("rng", rng, np.random.Generator) or np.random.default_rng(0)
    return _Following(problem, required, options, draws, tracker).run()


def _tracker(budget: Budget, cancel: Event | None, progress: Progress | None) -> BudgetTracker:
    one_of("budget", budget, Budget)
    if budget.attempts is not None or budget.workers > 1 or budget.improve:
        raise ProblemError("a curve is followed in one attempt: its budget takes seconds and work only")
    return BudgetTracker(budget, cancel, progress)


@dataclass(eq=False)
class _Following:
    problem: Problem
    required: FollowsCurve
    options: FollowOptions
    rng: np.random.Generator
    tracker: BudgetTracker

    @cached_property
    def on_curve(self) -> OnCurve:
        reduced = self.problem.reduced
        return OnCurve(reduced, self.required, evaluator(reduced, WorkCounts()), self.tracker)

    def run(self) -> Followed:
        try:
            return self._run()
        except Stopped as ended:
            words = f"after {self.tracker.work} configurations, in {self.tracker.used:.3g} s"
            result = self._nothing(stop_reason(self.on_curve, ENDED[ended.stop], 0.0, words))
            return replace(result, result=replace(result.result, stopped=ended.stop))

    def _run(self) -> Followed:
        with self.on_curve.stage("start"):
            starts, refusal = self._starts()
        if refusal is not None:
            return self._nothing(refusal)
        found = self._searched(starts)
        if found.stop is not None and self.required.rotation_tolerance > CURVE_ROTATION:
            upright, self.on_curve = self.on_curve, self.on_curve.tilting()
            tilted = self._searched(starts)
            if tilted.way.reached > found.way.reached:
                found = tilted
            else:
                self.on_curve = upright
        if found.stop is not None and self.options.avoid is Avoid.DEVIATE:
            around = self._around(starts, found.stop)
            if around is not None:
                return around
        if found.stop is not None and found.way.reached < LEAST * self.required.until:
            return self._nothing(found.stop)
        return self._motion(found)

    def _searched(self, starts: Floats) -> Found:
        search = CurveSearch(self.problem, self.on_curve, self.rng)
        with self.on_curve.stage("track"):
            found = search.tracked(starts)
        if found.stop is not None and self.on_curve.spare:
            with self.on_curve.stage("look ahead"):
                found = search.looking_ahead(starts, found)
        return search.as_program(found) if self.on_curve.spare else found

    def _starts(self) -> tuple[Floats, StopReason | None]:
        reduced, on_curve = self.problem.reduced, self.on_curve
        nothing = np.empty((0, len(reduced.joint_names)))
        if self.options.begin is Begin.ANY_BRANCH:
            found = beginnings(on_curve, most=self.options.branches, rng=self.rng)
            return (nothing, found) if isinstance(found, StopReason) else (found, None)
        judge = Judge(reduced)
        seen = judge.examine(reduced.start_positions, moment=Moment.START)
        if seen.out_of_limits:
            words = reasons.out_of_limits(seen)
            return nothing, stop_reason(on_curve, Status.START_OUT_OF_LIMITS, 0.0, words)
        if seen.collisions:
            worst = seen.collisions[0]
            return nothing, stop_reason(
                on_curve,
                Status.START_IN_COLLISION,
                0.0,
                reasons.collisions(seen),
                pair=(worst.first, worst.second),
                amount=worst.required - worst.distance,
            )
        weak = judge.overloads(reduced.start_positions, limits=self.problem.limits)
        if weak:
            words = reasons.overloaded(weak, "at the start")
            return nothing, stop_reason(
                on_curve, Status.START_CANNOT_BE_HELD, 0.0, words, joint=weak[0].joint
            )
        start = reduced.start_positions[None]
        position, turn = on_curve.off(start, np.zeros(1))
        allowed = self.required.position_tolerance, self.required.rotation_tolerance
        if position[0] > START_SHARE * allowed[0] or turn[0] > START_SHARE * allowed[1]:
            words = (
                f"{self.required.frame} is {in_length(position[0])} and {in_degrees(turn[0])} away "
                "from the beginning of the curve: move there first, or begin with Begin.ANY_BRANCH"
            )
            return nothing, stop_reason(on_curve, Status.START_BREAKS_CONSTRAINT, 0.0, words)
        return start, None

    def _motion(self, found: Found) -> Followed:
        way, why = found.way, found.stop
        part = self.required if why is None else replace(self.required, until=way.reached)
        problem = replace(beginning(self.problem, way), goal=part, constraints=(part,))
        on_curve = self.on_curve.along(part, problem.reduced)
        result = self._judged(problem, on_curve, way)
        if isinstance(result, StopReason):
            return self._nothing(result, problem)
        if not result.verified:
            why = stop_reason(on_curve, Status.NOT_VERIFIED, 0.0, result.message)
        return self._followed(result, part.until / self.required.until if result.verified else 0.0, why)

    def _judged(self, problem: Problem, on_curve: OnCurve, way: CurveTrack) -> Result | StopReason:
        workspace, result = PlanningWorkspace(problem, self.tracker), None
        for chord, rounding in zip(CHORDS, ROUNDINGS, strict=True):
            with on_curve.stage("densify"):
                dense = densified(on_curve, way, tolerance=chord * on_curve.allowed)
            path = Path(problem.reduced.joint_names, readonly(dense.positions))
            with on_curve.stage("retime"):
                timed = timed_along(problem, on_curve, path, tolerance=rounding * on_curve.allowed)
            if isinstance(timed, RetimeFailure):
                at = timed.place * on_curve.required.until
                return stop_reason(on_curve, Status.NO_TIMING, at, timed.reason, joint=timed.joint)
            result = workspace.judged(MotionCandidate(path, timed.trajectory, timed))
            if result.verified:
                break
        assert result is not None
        return result

    def _around(self, starts: Floats, why: StopReason) -> Followed | None:
        tube = self.options.tube
        wide = replace(self.required, position_tolerance=tube)
        for detour in detours(self.problem, self.on_curve, starts, tube):
            problem = replace(beginning(self.problem, detour.way), constraints=(wide,))
            on_detour = self.on_curve.along(detour.required, problem.reduced)
            result = self._judged(problem, on_detour, detour.way)
            if isinstance(result, Result) and result.verified:
                return self._followed(result, 1.0, None, around=why)
        return None

    def _nothing(self, why: StopReason, problem: Problem | None = None) -> Followed:
        workspace = PlanningWorkspace(problem or self.problem, self.tracker)
        return self._followed(workspace.result(why.status, why.message), 0.0, why)

    def _followed(
        self, result: Result, fraction: float, why: StopReason | None, *, around: StopReason | None = None
    ) -> Followed:
        return Followed(required=self.required, fraction=fraction, stop=why, around=around, result=result)


BODIES = 0.1
"""Deviation of the rest of the arm, relative to the tool's."""
POINTS_PER_KNOT = 0.7
"""Further points of the motion for each knot of the path."""
MOST_POINTS = 600
"""Most points of the motion."""
SHARP = np.radians(25.0)
"""The motion stops at corners of the joint path with a larger angle [rad]."""
DWELL = 2e-3
"""Duration of an acceleration change at rest in a corner, without a jerk limit [s]."""


def timed_along(
    problem: Problem, on_curve: OnCurve, path: Path, *, tolerance: float
) -> Retimed | RetimeFailure:
    """Find the fastest timing of a path within all limits of the problem.

    Args:
        tolerance: Largest deviation of the tool from the path, rotations counted as lengths [m].
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
    steps = np.diff(knots, axis=0) / np.where(velocity > 0.0, velocity, 1.0)
    sizes = np.linalg.norm(steps, axis=1)
    along = (steps[:-1] * steps[1:]).sum(axis=1) / np.maximum(sizes[:-1] * sizes[1:], 1e-300)
    sharp = (along < np.cos(SHARP)) & (sizes[:-1] > 0.0) & (sizes[1:] > 0.0)
    return tuple((np.flatnonzero(sharp) + 1).tolist())


def _together(legs: Sequence[Retimed]) -> Retimed:
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
    """Join trajectories; an acceleration jump becomes a short change at rest."""
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
    assert motion.velocities is not None
    assert motion.accelerations is not None
    return np.stack((motion.positions, motion.velocities, motion.accelerations))
