"""The goals of a supervisor, in order, and the motions to them."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import TypeAlias, cast

from trajopt.driving.active_motion import ActiveMotion, Pause, PieceStatus
from trajopt.driving.commit_loop import Commitment
from trajopt.driving.events import Event, EventKind
from trajopt.driving.intended_motion import GuardedGoal, IntendedMotion
from trajopt.driving.motion_guard import reason_with_margin
from trajopt.driving.options import SupervisorOptions
from trajopt.driving.replanning import (
    Transition,
    from_rest,
    passing,
    replan_from,
    retime_on_path,
    return_to_path,
)
from trajopt.planning.result import Plan, Result
from trajopt.planning.status import Status
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import Requirement, frame_placement
from trajopt.problem.stated import GoalLike
from trajopt.scene.scene import Scene
from trajopt.timing.time_scaling import JOLT
from trajopt.values.arrays import Floats, Printed
from trajopt.values.placement import Placement
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Judge

GoalNow: TypeAlias = Callable[[], GoalLike | Sequence[GoalLike] | None]
"""Returns the present goal, in any form that a problem accepts; None if it is not known."""
SOONER = 0.95
"""A new motion replaces one that waits only if it takes less than this share of the remaining time."""


@dataclass(eq=False)
class FollowedGoal(Printed):
    """A goal that moves while the robot drives to it.

    Attributes:
        target: A frame of the scene for the tool, or a function that returns the goal.
        tolerance: As for `Supervisor.follow_goal` [m | rad].
        holds_since: Since when it has held [s]; None while it does not.
        begin: When the last planned motion begins: no other is planned before [s].
    """

    goal: GuardedGoal
    target: str | GoalNow
    offset: Placement
    tool: str
    tolerance: float
    hold: float
    holds_since: float | None = None
    requested: GuardedGoal | None = None
    begin: float = -inf
    _judge: tuple[Scene, Judge] | None = field(default=None, repr=False)

    def updated(self, here: Problem) -> Problem:
        scene, problem = here.scene, self.goal.problem
        if isinstance(self.target, str):
            where = scene.placement_of(self.target, here.start_positions) * self.offset
            goal: object = frame_placement(self.tool, where)
        else:
            goal = self.target()
        if goal is not None:
            problem = replace(problem, goal=cast("GoalLike", goal), scene=scene)
            self.goal = replace(self.goal, problem=problem)
        return problem

    def holds(self, problem: Problem, positions: Floats) -> bool:
        """Return whether a goal holds within the tolerance at positions of the group, shape (n,)."""
        scene = problem.scene
        if self._judge is None or self._judge[0] is not scene:
            self._judge = scene, Judge(problem.reduced)
        judge = self._judge[1]
        alternatives = list(problem.alternatives.values()) or [problem]
        return any(
            all(
                check.holds or not check.required
                for check in judge.check(positions, [_relaxed(goal, self.tolerance) for goal in each.goals])
            )
            for each in alternatives
        )


def _relaxed(goal: Requirement, by: float) -> Requirement:
    for number in range(len(goal.relaxations)):
        goal = goal.relaxations[number].apply(by)
    return goal


@dataclass(eq=False)
class _PlanRequest(Printed):
    """The plan that is to be made for the present goal.

    Attributes:
        not_before: Time of the next attempt [s]; infinite until the world changes.
        only_sooner: Whether the active motion only waits, and is replaced only by one that ends sooner.
        lead: Time allowed for a plan from rest, beyond the options' [s].
    """

    goal: GuardedGoal | None = None
    not_before: float = 0.0
    failed: float = -inf
    only_sooner: bool = False
    lead: float = 0.0

    def replace_goal(self, goal: GuardedGoal | None) -> None:
        self.goal, self.not_before = goal, 0.0

    def require(self, goal: GuardedGoal) -> None:
        self.goal = self.goal or goal

    def fulfilled(self) -> None:
        self.goal, self.only_sooner = None, False


@dataclass(eq=False)
class _NextGoal(Printed):
    transition: Transition | None = None
    not_before: float = 0.0


@dataclass(eq=False)
class GoalQueue(Printed):
    """Plans the motions to the goals of a supervisor, one after another."""

    commitment: Commitment
    active: ActiveMotion
    options: SupervisorOptions
    later: deque[GuardedGoal] = field(default_factory=deque[GuardedGoal])
    followed: FollowedGoal | None = None
    _request: _PlanRequest = field(default_factory=_PlanRequest)
    _next: _NextGoal = field(default_factory=_NextGoal)
    _due: deque[tuple[Event, GuardedGoal]] = field(default_factory=deque[tuple[Event, GuardedGoal]])
    _uncertainty_noted: bool = False

    @property
    def open(self) -> bool:
        goals = self._request.goal is not None or bool(self.later) or self.followed is not None
        return goals or self.active.intended is not None or self.active.pause is not None

    @property
    def given_up(self) -> bool:
        return self._request.goal is not None and self._request.not_before == inf

    def go(self, goal: GuardedGoal) -> None:
        self.clear()
        self._request.replace_goal(goal)

    def then(self, goal: GuardedGoal) -> None:
        self.later.append(goal)

    def follow(self, followed: FollowedGoal) -> None:
        self.clear()
        self.followed, self._request.not_before = followed, 0.0

    def clear(self) -> None:
        self._request.fulfilled()
        self.followed, self._next.transition = None, None
        self.active.forget_pause()
        self.later.clear()

    def abandon(self) -> None:
        self.clear()
        self._due.clear()
        self.active.leave()

    def drive(self, goal: GuardedGoal, plan: Plan, at: float) -> bool:
        """Drive a planned motion instead of all goals, from rest; return whether it is proven.

        Args:
            at: Its begin on the executor's clock [s]; it may begin later.
        """
        commitment, now = self.commitment, self.commitment.executor.now()
        if commitment.stale(at) or not goal.guard.proven(plan.trajectory, commitment.world, at):
            return False
        begin = self._begin_from_rest(goal, plan.trajectory, at, now)
        if begin is None:
            return False
        self.clear()
        self._planned(goal, plan, begin)
        return True

    def withdraw(self) -> tuple[str, ...]:
        """Drop all goals; return the waypoints not passed when the robot comes to rest."""
        intended, pause = self.active.intended, self.active.coming_rest
        begun = intended or (None if pause is None else pause.intended)
        goal = self._request.goal or (None if begun is None else begun.goal)
        on_its_way = pause is not None and pause.intended.goal is goal
        passed = pause.intended.passed(pause.rests_at) if pause is not None and on_its_way else ()
        self.abandon()
        return () if goal is None else tuple(n for n in goal.problem.waypoint_names if n not in passed)

    def interrupted(self) -> None:
        goals = [goal for _, goal in self._due]
        intended = self.active.intended
        present = self._request.goal or (None if intended is None else intended.goal)
        now = self.commitment.executor.now()
        goals += [] if present is None else [self.active.beyond_waypoints(present, now)]
        self._due.clear()
        self._request.goal, self._next.transition = None, None
        if goals:
            self._request.goal = goals[0]
            self.later.extendleft(reversed(goals[1:]))

    def world_changed(self) -> None:
        """Judge the rest of the active motion, and the next one, in the world as last reported."""
        request, following, active = self._request, self._next, self.active
        request.not_before = min(request.not_before, request.failed + self.options.retry)
        following.not_before = 0.0
        coming = following.transition
        if coming is not None and not self._proven(coming.intended, coming.intended.begin):
            following.transition = None
        intended = active.intended
        if intended is None:
            return
        if active.partly_committed and not self._proven(intended, active.brake_time):
            if not self._only_uncertain(intended, active.brake_time):  # else it is extended as far as proven
                request.require(intended.goal)
                request.only_sooner, following.transition = False, None
            return
        self.commitment.journal.note(EventKind.STILL_CLEAR)
        if intended.held_back and active.partly_committed and request.goal is None:
            request.goal, request.only_sooner = intended.goal, True

    def advance(self, now: float) -> None:
        """Plan, and commit the next piece."""
        request = self._request
        if self.followed is not None:
            self._update_followed(self.followed, now)
        pause = self.active.pause
        same_goal = pause is not None and (request.goal is None or request.goal is pause.intended.goal)
        if same_goal and self.active.resume(now):
            request.goal, self._uncertainty_noted = None, False
        if request.goal is not None and now >= request.not_before:
            self._plan(request.goal, now)
        self._proceed(self.commitment.executor.now())  # a plan takes time
        if request.goal is None and self.later and now >= self._next.not_before:
            self._plan_next(now)

    def _plan(self, goal: GuardedGoal, now: float) -> None:
        commitment, active, options, request = self.commitment, self.active, self.options, self._request
        branch, rest = active.branch_time(now), commitment.motion.end
        moving = branch is not None
        at = max(rest + 2.0 * JOLT, now + max(options.ahead, request.lead)) if branch is None else branch
        if moving and (not options.on_the_way or at < commitment.soonest):
            return  # it brakes, or will
        if not moving and rest > now + options.ahead:
            return  # it is coming to rest
        pause = active.pause
        uncertain = pause is not None and pause.intended.goal is goal and self._only_uncertain(pause, at)
        if commitment.stale(at) or uncertain:
            request.not_before = now + options.retry
            return
        goal = request.goal = active.beyond_waypoints(goal, at)
        if moving and self._retimed(goal, at):
            return
        with commitment.journal.stage("plan"):
            result = replan_from(active, goal, at, only_sooner=request.only_sooner)
        if moving and commitment.soonest > at:
            reason = "" if result.verified else result.reason
            self._plan_failed(EventKind.MISSED_DEADLINE, reason, repeatable=False)
            return
        if not moving and self._returns_to_path(goal, max(at, commitment.soonest), result):
            return
        if not result.verified:
            reason = reason_with_margin(result, goal.guard.deviation)
            self._plan_failed(EventKind.NO_PLAN, reason, repeatable=not moving)
            return
        planned = result.require()
        begin = at if moving else self._begin_from_rest(goal, planned.trajectory, at, now)
        if begin is not None:
            self._planned(goal, planned, begin)

    def _begin_from_rest(
        self, goal: GuardedGoal, trajectory: Trajectory, at: float, asked: float
    ) -> float | None:
        commitment, now = self.commitment, self.commitment.executor.now()
        if commitment.soonest <= at:
            return at
        later, world = now + self.options.ahead, commitment.world
        if not world.scene.changing:
            return later
        if not commitment.stale(later) and goal.guard.proven(trajectory, world, later):
            return later
        self._request.lead = 2.0 * (now - asked)
        return None

    def _returns_to_path(self, goal: GuardedGoal, at: float, result: Result) -> bool:
        commitment = self.commitment
        if result.status is not Status.START_BREAKS_CONSTRAINT:
            return False
        with commitment.journal.stage("plan"):
            motion = return_to_path(commitment, goal.problem, at, self.options.budget)
        if motion is None or not commitment.splice(motion, at):
            return False
        commitment.constrained = False
        commitment.journal.note(
            EventKind.RECOVERING, f"back to its path, which it left for a stop: {result.reason}"
        )
        return True

    def _planned(self, goal: GuardedGoal, plan: Plan, at: float) -> None:
        intended, request, trajectory = self.active.intended, self._request, plan.trajectory
        only_sooner = request.only_sooner
        request.fulfilled()
        if intended is not None and only_sooner and trajectory.duration > SOONER * (intended.end - at):
            return
        kind = EventKind.STARTED if intended is None else EventKind.REPLANNED
        self.commitment.journal.note(kind, f"{trajectory.duration:.3f} s to the goal")
        self._take(IntendedMotion.of(goal, plan, at))
        if self.followed is not None:
            self.followed.begin = at

    def _plan_failed(self, kind: EventKind, words: str, *, repeatable: bool) -> None:
        commitment, now, request = self.commitment, self.commitment.executor.now(), self._request
        if request.only_sooner:
            request.fulfilled()
            return
        commitment.journal.note(kind, words)
        hopeless = repeatable and not commitment.world.scene.changing and self.followed is None
        request.failed, request.not_before = now, inf if hopeless else now + self.options.retry

    def _retimed(self, goal: GuardedGoal, at: float) -> bool:
        commitment, intended, patience = self.commitment, self.active.intended, self.options.patience
        if not patience or not commitment.world.scene.changing or self._request.only_sooner:
            return False
        if intended is None or intended.goal is not goal:
            return False
        with commitment.journal.stage("retime"):
            here = commitment.continued(goal.problem, at, commitment.world)
            found = retime_on_path(commitment, intended, here, at, patience)
        if found is None or commitment.soonest > at:
            return False
        commitment.journal.note(EventKind.SLOWING, "; ".join(found.remarks) or "the same path, hardly slower")
        self._take(intended.retimed(found.trajectory, at))
        self._request.goal = None
        return True

    def _take(self, intended: IntendedMotion) -> None:
        self.active.take(intended)
        self._next = _NextGoal()

    def _plan_next(self, now: float) -> None:
        commitment, before, following = self.commitment, self.active.intended, self._next
        if before is None:
            return
        coming = following.transition
        if coming is not None:
            if coming.kind is not EventKind.PASSED and before.goal.blend_radius:
                with commitment.journal.stage("plan ahead"):
                    following.transition = passing(commitment, self.options, before, coming)
                following.not_before = inf  # tried once
            return
        with commitment.journal.stage("plan ahead"):
            following.transition, words = from_rest(commitment, self.options, before, self.later[0])
        following.not_before = now
        if following.transition is None:
            commitment.journal.note(EventKind.NO_PLAN, f"to the next goal: {words}")
            changing = bool(commitment.world.scene.changing)
            following.not_before = now + self.options.retry if changing else inf

    def _proceed(self, now: float) -> None:
        while self._due and self._due[0][0].time <= now:
            event, _ = self._due.popleft()
            self.commitment.journal.note(event.kind, event.words)
        intended = self.active.intended
        if intended is None:
            idle = self._request.goal is None and self.active.pause is None and self.followed is None
            if idle and self.later:
                self._request.replace_goal(self.later.popleft())
        elif now >= intended.end and not self.active.partly_committed:
            self._arrived(intended)
        elif not self._changed_over(intended, now):
            self._extend(intended, now)

    def _extend(self, intended: IntendedMotion, now: float) -> None:
        active, journal, request = self.active, self.commitment.journal, self._request
        status = active.extend(now)
        if status is PieceStatus.UNPROVEN and not self._gave_up_begin(intended, now):
            # Until it brakes, the next piece may become clear or be replanned.
            if not self._only_uncertain(intended, active.brake_time):
                request.require(intended.goal)
            elif not self._uncertainty_noted:
                self._uncertainty_noted = True
                journal.note(EventKind.STALE, self.commitment.world.growing_errors(active.brake_time))
        elif status is PieceStatus.BRAKING:
            request.require(intended.goal)
            request.not_before = 0.0
            journal.note(EventKind.STOPPING, "no further piece of the motion was proven in time")

    def _gave_up_begin(self, intended: IntendedMotion, now: float) -> bool:
        commitment, active = self.commitment, self.active
        if active.brake_time > intended.begin or commitment.world.scene.changing:
            return False
        self._request.require(intended.goal)
        self._request.not_before = now + self.options.retry
        if now >= commitment.motion.end:
            words = active.failed_check(intended, active.brake_time, now)
            active.leave()
            self._plan_failed(
                EventKind.NO_PLAN, f"the planned motion is not proven: {words}", repeatable=True
            )
        return True

    def _changed_over(self, before: IntendedMotion, now: float) -> bool:
        active, following = self.active, self._next
        coming = following.transition
        if coming is None:
            return False
        onward = coming.intended
        if active.brake_time < min(onward.begin, before.end):
            return False
        late = onward.begin < self.commitment.soonest
        if late or not active.commit(onward, onward.begin, now):
            if late or coming.kind is EventKind.PASSED:
                following.transition, following.not_before = coming.at_rest, inf
            return False
        self._next = _NextGoal()
        event = Event(min(onward.begin, before.end), coming.kind, coming.words)
        self._due.append((event, before.goal))
        self.later.popleft()
        return True

    def _arrived(self, intended: IntendedMotion) -> None:
        self.active.leave()
        self._next.transition = None
        reached = self._request.goal is None or self._request.goal is intended.goal
        if reached and self.followed is None:
            self._request.goal = None
            self.commitment.journal.note(EventKind.REACHED)

    def _update_followed(self, followed: FollowedGoal, now: float) -> None:
        commitment, intended, request = self.commitment, self.active.intended, self._request
        arrival = max(commitment.motion.end if intended is None else intended.end, now)
        if commitment.stale(arrival):
            return
        here = commitment.resting(followed.goal.problem, arrival, commitment.world.at(arrival))
        if intended is None:
            end = here.reduced.start_positions
        else:
            end = intended.trajectory(intended.trajectory.duration)
        problem = followed.updated(here)
        if not followed.holds(problem, end):
            followed.holds_since = None
            if now >= followed.begin or intended is None:
                request.goal = followed.requested = replace(followed.goal, problem=problem)
            return
        if request.goal is followed.requested:
            request.goal = None
        if intended is not None or commitment.motion.end > now or self.active.pause is not None:
            return
        if followed.holds_since is None:
            followed.holds_since = now
        if now - followed.holds_since >= followed.hold:
            self.followed = None
            commitment.journal.note(EventKind.REACHED)

    def _only_uncertain(self, rest: IntendedMotion | Pause, time: float) -> bool:
        changing = bool(self.commitment.world.scene.changing)
        return changing and self.active.clear_without_growing_errors(rest, time)

    def _proven(self, intended: IntendedMotion, begin: float) -> bool:
        commitment = self.commitment
        return not commitment.stale(begin) and intended.goal.guard.proven(
            intended.after(begin), commitment.world, begin
        )
