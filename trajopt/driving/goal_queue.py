"""The goals of a supervisor, one after the other, and the motions to them."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import TypeAlias, cast

from trajopt.driving.active_motion import ActiveMotion, Pause, PieceStatus
from trajopt.driving.commit_loop import Commitment
from trajopt.driving.events import Event, EventKind
from trajopt.driving.intended_motion import GuardedGoal, IntendedMotion
from trajopt.driving.motion_guard import with_margin_share
from trajopt.driving.options import SupervisorOptions
from trajopt.driving.replanning import (
    Transition,
    from_rest,
    passing,
    replanned,
    retime_on_path,
    return_to_path,
)
from trajopt.driving.world_snapshot import position_errors
from trajopt.planning.result import Result
from trajopt.planning.status import Status
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import Requirement, frame_placement
from trajopt.problem.stated import GoalLike
from trajopt.scene.scene import Scene
from trajopt.timing.standing import JOLT
from trajopt.values.arrays import Floats, Printed
from trajopt.values.placement import Placement
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Judge

GoalNow: TypeAlias = Callable[[], GoalLike | Sequence[GoalLike] | None]
"""Returns the goal as it is now, in any form that a problem takes; None where nobody knows."""


@dataclass(eq=False)
class FollowedGoal(Printed):
    """A goal that moves while the robot drives to it.

    Attributes:
        goal: What is required on the way; the goal of its problem is where it was last.
        target: A frame of the scene that the group's tool goes to, or what returns the goal.
        offset: Where the tool goes as seen from the frame.
        tool: Which frame of the robot goes there.
        tolerance: By how much more than its own tolerances a goal may be missed before it is planned to anew
            [m | rad].
        hold: The goal is reached when it has held for so long while the robot stands [s].
        holds_since: Since when it has [s]; None while it does not.
        requested: The goal that a motion was asked to last, as the motion at hand misses it.
        again: When the last motion that was planned begins: to plan again before is no use [s].
    """

    goal: GuardedGoal
    target: str | GoalNow
    offset: Placement
    tool: str
    tolerance: float
    hold: float
    holds_since: float | None = None
    requested: GuardedGoal | None = None
    again: float = -inf
    _judge: tuple[Scene, Judge] | None = field(default=None, repr=False)

    def aimed(self, here: Problem) -> Problem:
        """Return the problem with the goal as it is.

        Args:
            here: With the scene as it is at the time of interest.

        Raises:
            FrameNotFound: If the frame is not in the scene.
            ProblemError: If what the function returns is no goal.
        """
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

    def holds(self, aimed: Problem, positions: Floats) -> bool:
        """Say whether a goal holds at positions of the group's joints, shape (n,), more or less."""
        scene = aimed.scene
        if self._judge is None or self._judge[0] is not scene:
            self._judge = scene, Judge(aimed.reduced)
        judge = self._judge[1]
        alternatives = list(aimed.alternatives.values()) or [aimed]
        return any(
            all(
                check.holds or not check.required
                for check in judge.check(positions, [_relaxed(goal, self.tolerance) for goal in each.goals])
            )
            for each in alternatives
        )


def _relaxed(goal: Requirement, by: float) -> Requirement:
    """Return a goal with all its tolerances larger by an amount [m | rad]."""
    for number in range(len(goal.relaxations)):
        goal = goal.relaxations[number].apply(by)
    return goal


SOONER = 0.95
"""A new motion is taken in place of one that waits only if it is over in less than this part of its time."""


@dataclass(eq=False)
class GoalQueue(Printed):
    """The goals that a robot is to go to, one after the other, and the motions there.

    Attributes:
        commitment: What the robot will do whatever comes.
        running: The motion that it is on.
        options: Of the supervisor.
        pending: The goal that a motion is to be planned to; None where it is on the right one.
        later: Goals after that.
        following: A goal that moves; None where it stands still.
    """

    commitment: Commitment
    running: ActiveMotion
    options: SupervisorOptions
    pending: GuardedGoal | None = None
    later: deque[GuardedGoal] = field(default_factory=deque[GuardedGoal])
    following: FollowedGoal | None = None
    _next: Transition | None = None
    _due: deque[tuple[Event, GuardedGoal]] = field(default_factory=deque[tuple[Event, GuardedGoal]])
    _again: float = 0.0
    _failed: float = -inf
    _next_again: float = 0.0
    _hurry: bool = False
    _doubted: bool = False
    _lead: float = 0.0

    @property
    def open(self) -> bool:
        """Whether there is a goal that is not reached."""
        goals = self.pending is not None or bool(self.later) or self.following is not None
        return goals or self.running.intended is not None or self.running.pause is not None

    @property
    def given_up(self) -> bool:
        """Whether there is no plan to the goal, nor will there be in the world as it is known."""
        return self.pending is not None and self._again == inf

    def go(self, goal: GuardedGoal) -> None:
        """Go to a goal in place of all others."""
        self.forget()
        self.pending, self._again = goal, 0.0

    def forget(self) -> None:
        """Have no goals any more, but the motion that the robot is on."""
        self.pending = self.following = self._next = None
        self.running.pause, self._hurry = None, False
        self.later.clear()

    def then(self, goal: GuardedGoal) -> None:
        """Go to a goal after all others."""
        self.later.append(goal)

    def follow(self, following: FollowedGoal) -> None:
        """Follow a goal that moves in place of all others."""
        self.forget()
        self.following, self._again = following, 0.0

    def interrupted(self) -> None:
        """Go on to what is not reached yet, once the robot is stopped on its way there."""
        goals = [goal for _, goal in self._due]
        going = self.pending or (None if self.running.intended is None else self.running.intended.goal)
        goals += [] if going is None else [going]
        self._due.clear()
        self.pending, self._next = None, None
        if goals:
            self.pending = goals[0]
            self.later.extendleft(reversed(goals[1:]))

    def abandon(self) -> None:
        """Have no goals any more, nor a motion to any."""
        self.forget()
        self._due.clear()
        self.running.leave()

    def look_again(self) -> None:
        """Judge what is left of the motion, and the next, in the world as it is known now."""
        self._again, self._next_again = min(self._again, self._failed + self.options.retry), 0.0
        coming, running = self._next, self.running
        if coming is not None and not self._holds(coming.intended, coming.intended.begin):
            self._next = None
        intended = running.intended
        if intended is None:
            return
        holds = not running.in_motion or self._holds(intended, running.parting)
        if not holds and self._only_uncertain(intended, running.parting):
            return  # it is gone on along as far as that is proven, maybe slower
        if not holds:
            self.pending, self._next, self._hurry = self.pending or intended.goal, None, False
            return
        self.commitment.journal.note(EventKind.STILL_CLEAR)
        if intended.held_back and running.in_motion and self.pending is None:
            self.pending, self._hurry = intended.goal, True

    def work(self, now: float) -> None:
        """Plan what is to be planned, and commit what comes next."""
        if self.following is not None:
            self._follow(self.following, now)
        pause = self.running.pause
        same = pause is not None and (self.pending is None or self.pending is pause.intended.goal)
        if same and self.running.resume(now):
            self.pending, self._doubted = None, False
        if self.pending is not None and now >= self._again:
            self._plan(self.pending, now)
        self._get_on(self.commitment.executor.now())  # a plan may have taken long
        if self.pending is None and self.later and now >= self._next_again:
            self._plan_ahead(now)

    def _plan(self, goal: GuardedGoal, now: float) -> None:
        """Plan to a goal from where the robot parts from its motion, or stands."""
        commitment, running, options = self.commitment, self.running, self.options
        parts, rest = running.parts(now), commitment.motion.end
        in_motion = parts is not None
        at = max(rest + 2.0 * JOLT, now + max(options.ahead, self._lead)) if parts is None else parts
        if in_motion and (not options.on_the_way or at < commitment.soonest):
            return  # it is let brake, or brakes already
        if not in_motion and rest > now + options.ahead:
            return  # it is on its way to rest
        pause = running.pause
        uncertain = pause is not None and pause.intended.goal is goal and self._only_uncertain(pause, at)
        if commitment.stale(at) or uncertain:
            self._again = now + options.retry
            return
        if in_motion and self._retimed(goal, at):
            return
        with commitment.journal.stage("plan"):
            result = replanned(running, goal, at, hurry=self._hurry)
        if in_motion and commitment.soonest > at:
            self._not_planned(EventKind.MISSED_DEADLINE, "" if result.verified else result.reason, same=False)
            return
        if not in_motion and self._goes_back(goal, max(at, commitment.soonest), result):
            return
        if not result.verified:
            words = with_margin_share(result, goal.guard.deviation)
            self._not_planned(EventKind.NO_PLAN, words, same=not in_motion)
            return
        trajectory = result.require().trajectory
        begin = at if in_motion else self._begin_at_rest(goal, trajectory, at, now)
        if begin is not None:
            self._planned(goal, trajectory, begin)

    def _begin_at_rest(
        self, goal: GuardedGoal, trajectory: Trajectory, at: float, asked: float
    ) -> float | None:
        """Return when a motion from rest begins [s]: later than planned, if planning took longer.

        Where something moves it may not hold later on; then the next plan is allowed twice the time.
        """
        commitment, now = self.commitment, self.commitment.executor.now()
        if commitment.soonest <= at:
            return at
        later, world = now + self.options.ahead, commitment.world
        if not world.scene.changing:
            return later
        if not commitment.stale(later) and goal.guard.proven(trajectory, world, later):
            return later
        self._lead = 2.0 * (now - asked)
        return None

    def _goes_back(self, goal: GuardedGoal, at: float, result: Result) -> bool:
        """Bring the robot back to where a stop led it off its path, if nothing may begin where it stands."""
        commitment = self.commitment
        if result.status is not Status.START_BREAKS_CONSTRAINT:
            return False
        with commitment.journal.stage("plan"):
            motion = return_to_path(commitment, goal.problem, at, self.options.budget)
        if motion is None or not commitment.splice(motion, at):
            return False
        commitment.held = False
        commitment.journal.note(
            EventKind.RECOVERING, f"back to where it left its path to stop: {result.reason}"
        )
        return True

    def _planned(self, goal: GuardedGoal, trajectory: Trajectory, at: float) -> None:
        """Take a motion that was planned, unless the one at hand is as good."""
        intended = self.running.intended
        hurry, self._hurry = self._hurry, False
        self.pending = None
        if intended is not None and hurry and trajectory.duration > SOONER * (intended.end - at):
            return
        kind = EventKind.STARTED if intended is None else EventKind.REPLANNED
        self.commitment.journal.note(kind, f"{trajectory.duration:.3f} s to the goal")
        self._take(IntendedMotion.of(goal, trajectory, at))
        if self.following is not None:
            self.following.again = at

    def _not_planned(self, kind: EventKind, words: str, *, same: bool) -> None:
        """Note that there is no plan, and when to try again."""
        commitment, now = self.commitment, self.commitment.executor.now()
        if self._hurry:  # there is a motion, which only waits
            self.pending, self._hurry = None, False
            return
        commitment.journal.note(kind, words)
        # Where nothing moves, the same question from the same place has the same answer.
        same = same and not commitment.world.scene.changing and self.following is None
        self._failed, self._again = now, inf if same else now + self.options.retry

    def _retimed(self, goal: GuardedGoal, at: float) -> bool:
        """Take the same path driven slower, where that keeps clear of what moves; say whether it does."""
        commitment, intended, patience = self.commitment, self.running.intended, self.options.patience
        if not patience or not commitment.world.scene.changing or self._hurry:
            return False
        if intended is None or intended.goal is not goal:
            return False
        with commitment.journal.stage("retime"):
            here = commitment.from_then(goal.problem, at, commitment.world)
            found = retime_on_path(intended, here, commitment.world, at, patience)
        if found is None or commitment.soonest > at:
            return False
        words = "; ".join(found.remarks) or "the same path, hardly slower"
        commitment.journal.note(EventKind.SLOWING, words)
        self._take(IntendedMotion.of(goal, found.trajectory, at, held_back=True))
        self.pending = None
        return True

    def _take(self, intended: IntendedMotion) -> None:
        self.running.take(intended)
        self._next, self._next_again = None, 0.0

    def _plan_ahead(self, now: float) -> None:
        """Plan from the motion that is being driven to the goal after it: from its end, then passing near."""
        commitment, before, coming = self.commitment, self.running.intended, self._next
        if before is None:
            return
        if coming is not None and (coming.kind is EventKind.PASSED or not before.goal.blend_radius):
            return
        with commitment.journal.stage("plan ahead"):
            if coming is None:
                self._next, words = from_rest(commitment, self.options, before, self.later[0])
            else:
                self._next, words = passing(commitment, self.options, before, coming)
        if self._next is None:
            commitment.journal.note(EventKind.NO_PLAN, f"to the goal after this one: {words}")
        same = self._next is None and not commitment.world.scene.changing
        again = now + self.options.retry if self._next is None else now
        # Passing is tried once; what is planned from rest does.
        self._next_again = inf if same or coming is not None else again

    def _get_on(self, now: float) -> None:
        """Commit what comes next, and note what is reached."""
        while self._due and self._due[0][0].time <= now:
            event, _ = self._due.popleft()
            self.commitment.journal.note(event.kind, event.words)
        intended = self.running.intended
        if intended is None:
            if self.pending is None and self.running.pause is None and self.following is None and self.later:
                self.pending, self._again = self.later.popleft(), 0.0
        elif now >= intended.end:
            self._arrived(intended)
        elif self._next is None or not self._turned(self._next, intended, now):
            self._extend(intended, now)

    def _extend(self, intended: IntendedMotion, now: float) -> None:
        """Commit the next piece of a motion."""
        running, journal = self.running, self.commitment.journal
        progress = running.extend(now)
        if progress is PieceStatus.UNPROVEN and not self._hopeless(intended, now):
            # There is time until it brakes: what comes next may be clear a cycle later, or planned anew.
            if not self._only_uncertain(intended, running.parting):
                self.pending = self.pending or intended.goal
            elif not self._doubted:
                self._doubted = True
                journal.note(EventKind.STALE, position_errors(self.commitment.world, running.parting))
        elif progress is PieceStatus.BRAKING:
            self.pending, self._again = self.pending or intended.goal, 0.0
            journal.note(EventKind.STOPPING, "nothing that goes on from there was proven in time")

    def _hopeless(self, intended: IntendedMotion, now: float) -> bool:
        """Give up a motion of which not even the begin is proven, where nothing moves; say whether it is.

        Planned anew from the same place it would be the same.
        """
        commitment, running = self.commitment, self.running
        if running.parting > intended.begin or commitment.world.scene.changing:
            return False
        self.pending, self._again = self.pending or intended.goal, now + self.options.retry
        if now >= commitment.motion.end:
            words = running.why_not(intended, running.parting, now)
            running.leave()
            self._not_planned(EventKind.NO_PLAN, f"what was planned is not proven: {words}", same=True)
        return True

    def _turned(self, coming: Transition, before: IntendedMotion, now: float) -> bool:
        """Turn from a motion to the next, where it is time for that; say whether it is done."""
        onward, running = coming.intended, self.running
        if running.parting < min(onward.begin, before.end):
            return False
        late = onward.begin < self.commitment.soonest
        if late or not running.commit(onward, onward.begin, now):
            if late or coming.kind is EventKind.PASSED:
                self._next, self._next_again = (
                    coming.at_rest if coming.kind is EventKind.PASSED else None,
                    inf,
                )
            return False
        self._next, self._next_again = None, 0.0
        self._due.append((Event(min(onward.begin, before.end), coming.kind, coming.words), before.goal))
        self.later.popleft()
        return True

    def _arrived(self, intended: IntendedMotion) -> None:
        """Be at rest at the end of a motion."""
        self.running.leave()
        self._next = None
        reached = self.pending is None or self.pending is intended.goal
        if reached and self.following is None:
            self.pending = None
            self.commitment.journal.note(EventKind.REACHED)

    def _follow(self, following: FollowedGoal, now: float) -> None:
        """See whether the motion leads to where the goal is now."""
        commitment, intended = self.commitment, self.running.intended
        arrival = max(commitment.motion.end if intended is None else intended.end, now)
        if commitment.stale(arrival):
            return
        here = commitment.still_at(following.goal.problem, arrival, commitment.world.at(arrival))
        if intended is None:
            end = here.reduced.start_positions
        else:
            end = intended.trajectory(intended.trajectory.duration)
        aimed = following.aimed(here)
        if not following.holds(aimed, end):
            following.holds_since = None
            if now < following.again and intended is not None:
                return
            self.pending = following.requested = replace(following.goal, problem=aimed)
            return
        if self.pending is following.requested:
            self.pending = None
        if intended is not None or commitment.motion.end > now or self.running.pause is not None:
            return
        if following.holds_since is None:
            following.holds_since = now
        if now - following.holds_since >= following.hold:
            self.following = None
            commitment.journal.note(EventKind.REACHED)

    def _only_uncertain(self, left: IntendedMotion | Pause, time: float) -> bool:
        """Whether nothing speaks against what is left of a motion but that things are known worse later."""
        changing = bool(self.commitment.world.scene.changing)
        return changing and self.running.would_be_clear(left, time)

    def _holds(self, intended: IntendedMotion, begin: float) -> bool:
        commitment = self.commitment
        return not commitment.stale(begin) and intended.goal.guard.proven(
            intended.left(begin), commitment.world, begin
        )
