"""Guard of a learned policy."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from trajopt.driving.action_chunk import ActionChunk, ActionMotion, along_actions, joints_of, quick_enough
from trajopt.driving.commit_loop import CommitLoop, joint_outside, refuse_rolling
from trajopt.driving.committed_motion import INSTANT, REST
from trajopt.driving.events import EventKind
from trajopt.driving.executor import Executor
from trajopt.driving.options import CLOCK_TOLERANCE
from trajopt.driving.servo_program import Braking, settle
from trajopt.driving.servo_task import joint_task
from trajopt.optimise.methods.timing import with_jerk
from trajopt.problem.problem import PathConstraint, Problem
from trajopt.scene.reducing import tool_frame
from trajopt.scene.scene import Scene
from trajopt.timing.time_scaling import stop_at_the_end
from trajopt.values.arrays import Floats, Value, at_least, floats, number, several
from trajopt.values.errors import JointNotFound, ProblemError, ShapeError
from trajopt.values.errors.arguments import checked, checked_class
from trajopt.values.placement import Placement
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Verdict
from trajopt.verify.checks.limits import LimitCriterion
from trajopt.verify.checks.required import RequirementCriterion
from trajopt.verify.checks.torques import TorqueCriterion

RATES = (1.0, 0.5, 0.25)
"""Rates at which the actions are tried, the next if no motion along them is within the limits."""
DEVIATIONS = (1e-5, 1e-3, 5e-3, 3e-2, 0.3, 3.0)
"""Deviations from the actions that weigh as much as the largest jerk [rad | m]: the repeatability of an
arm, the noise of a policy, the present acceleration that it overlooks, a jump of its actions, an arm that
comes up to speed, and actions far from the arm.
"""
SAME = 1e-3
"""Largest deviation at which an action counts as unchanged [rad | m]."""
SLOWEST, FASTEST = 1.0, 1000.0
"""Rates of policies [Hz]: the fastest controllers take a command in each millisecond."""
MOST_ACTIONS = 200
"""Most actions of a chunk: 4 s of a policy of 50 Hz."""
LARGEST = 1e6
"""Largest position of an action [rad | m]."""
REHEARSED = 1e-3
"""Motion of each joint in the rehearsal before the first decision [rad | m]."""
KEPT: dict[object, str] = {
    LimitCriterion: "the limits of the joints",
    TorqueCriterion: "the torque limits",
    RequirementCriterion: "the path constraints",
}
"""Names of what a motion does not keep, by criterion; others are about clearances."""
FAILURES = {EventKind.FAULT, EventKind.OFF_TRACK}
STEP, STEPS = 0.01, 4
"""Time step of the motion nearest to the actions [s], and its number of steps: two control cycles of 50 Hz,
so that one late call of `tick` does not stop the robot.
"""


class ActionOutcome(Enum):
    """Kinds of decisions about a chunk of actions; each value describes the committed motion."""

    AS_GIVEN = "the actions as given"
    SMOOTHED = "a motion near the actions within the limits"
    SHORTENED = "the first of the actions"
    SLOWED = "the actions at a lower rate"
    PROJECTED = "the nearest motion that is proven"
    STOPPED = "a stop"


@dataclass(frozen=True, eq=False)
class Decision(Value):
    """The decision of a guard about a chunk of actions.

    Attributes:
        outcome: Kind of the committed motion; a proven stop always follows it.
        unchanged: Actions committed as given.
        commanded: Committed positions at the times of the valid actions, shape (K, n) [rad | m].
    """

    outcome: ActionOutcome
    reason: str
    unchanged: int
    commanded: Floats


@checked
@dataclass(frozen=True, kw_only=True)
class GuardOptions:
    """Options of a guard.

    Attributes:
        lead: Time for a decision: the motion begins after this time and the executor's latency [s].
        clearance: Distance kept beyond the required clearances by the motion nearest to the actions, for the
            stop after it, which is not straight [m].
        clock_tolerance: Stamps ahead of the clock by up to this count as now [s].
    """

    lead: float = 0.01
    clearance: float = 0.005
    clock_tolerance: float = CLOCK_TOLERANCE

    def __post_init__(self) -> None:
        at_least(self, 0.0, "lead", "clearance", "clock_tolerance")


DEFAULT = GuardOptions()


@dataclass(frozen=True, eq=False)
class _Found:
    """A proven motion that follows the first `count` actions of a chunk, and a stop."""

    outcome: ActionOutcome
    motion: Trajectory
    chunk: ActionChunk
    count: int


@checked_class
class Guard(CommitLoop):
    """Drives the actions of a policy, each of them proven before it is driven.

    `act` takes a chunk of actions; `tick` watches robot and world, and goes on with a partly committed chunk.
    Call `tick` in every control cycle (20 ms).

    Attributes:
        problem: Robot, group, scene, limits and path constraints; its goal does not count.
        frame: Tool of actions that are poses.
    """

    def __init__(
        self,
        scene: Scene,
        group: str,
        executor: Executor,
        *,
        constraints: Sequence[PathConstraint] = (),
        frame: str = "",
        options: GuardOptions = DEFAULT,
    ) -> None:
        """Take over the robot at rest.

        Raises:
            JointNotFound: If the executor does not drive a joint of the group.
            ProblemError: If the robot moves, a joint of the group is outside its limits, or its base rolls.
        """
        here = dict(zip(executor.joint_names, executor.state().commanded.tolist(), strict=True))
        joints = scene.robot.group(group).joints
        at_rest = {name: here[name] for name in joints if name in here}
        if joints and not at_rest:
            raise JointNotFound("joint that is driven", joints[0], executor.joint_names)
        problem = Problem(scene=scene, group=group, start=here, goal=at_rest, constraints=constraints)
        for name in problem.reduced.joint_names:
            if outside := joint_outside(problem, name):
                raise ProblemError(f"{outside}; move it inside before a guard takes over")
        refuse_rolling(problem)
        super().__init__(executor, problem)
        self.options, self.frame = options, frame or tool_frame(problem.reduced)
        problem.reduced.attachment(self.frame)
        self._braking = Braking(with_jerk(problem.limits), STEP)
        self._near = self._commitment.approach_query(scene, self._braking, self.options.clearance)
        self._chunk: ActionChunk | None = None
        self._latest: ActionChunk | None = None
        self._next = -inf
        self._commitment.guard.prepare(self._commitment.world)
        self._rehearse()

    @property
    def seconds(self) -> dict[str, list[float]]:
        return self._commitment.journal.seconds

    def act(self, actions: ArrayLike, *, rate: float, stamp: float | None = None) -> Decision:
        """Replace the chunk of actions, and commit as much of it as is proven.

        Action k has to be reached at the time stamp + (k + 1) / rate; actions that are due before the motion
        can begin are dropped.

        Args:
            actions: Positions of the group's joints, shape (K, n), K at most 200 [rad | m]. Anything else
                stops the robot.
            rate: Actions per second, 1 to 1000 [Hz].
            stamp: Time of the observation, on the executor's clock [s]; now when None.

        Raises:
            ClockError: If the stamp is ahead of the executor's clock by more than `clock_tolerance`; the
                robot then goes on as committed.
            ProblemError: If the rate is outside its range.
        """
        nothing = np.zeros((0, len(self._commitment.joint_names)))
        try:
            targets = floats("actions", actions, (None, nothing.shape[1]))
        except ShapeError as error:
            return self._decide(nothing, str(error), rate, stamp)
        wrong = _wrong_number("actions", len(targets))
        if not wrong and np.abs(targets).max() > LARGEST:
            wrong = f"actions: a position is larger than {LARGEST:g}"
        return self._decide(nothing if wrong else targets, wrong, rate, stamp)

    def act_poses(self, poses: Sequence[Placement], *, rate: float, stamp: float | None = None) -> Decision:
        """Replace the chunk of actions by poses of the tool in the world; otherwise as `act`.

        The joints follow by inverse kinematics, up to the first pose not reached.
        """
        at = self._soonest
        wanted = several("poses", poses, Placement)
        if wrong := _wrong_number("poses", len(wanted)):
            return self._decide(np.zeros((0, len(self._commitment.joint_names))), wrong, rate, stamp)
        begin = self._near.positions(self._commitment.state(at)[0], self.world.clock(at))
        targets, wrong = joints_of(wanted, self.frame, begin, self._near.query, self.problem.limits)
        return self._decide(targets, wrong, rate, stamp)

    def _decide(self, targets: Floats, wrong: str, rate: float, stamp: float | None) -> Decision:
        if not SLOWEST <= number("rate", rate) <= FASTEST:
            raise ProblemError(f"rate must be from {SLOWEST:g} to {FASTEST:g} Hz, is {rate:g} Hz")
        stated = self._on_clock(stamp)
        times = stated + np.arange(1, len(targets) + 1) / rate
        with self._commitment.journal.stage("act"):
            if not self._watch():
                return self._stopped(self._failure, times)
            self._next = -inf
            if not len(targets):
                self._chunk = self._latest = None
                self._commitment.stop(self.problem, wrong, lambda _: None)
                return self._stopped(wrong, times)
            self._chunk = self._latest = ActionChunk.following(self._latest, targets, times)
            decision = self._advance(times)
        if wrong and decision.outcome in {ActionOutcome.AS_GIVEN, ActionOutcome.SMOOTHED}:
            decision = replace(decision, outcome=ActionOutcome.SHORTENED)
        return replace(decision, reason=wrong) if wrong else decision

    def tick(self) -> Decision | None:
        """Watch robot and world, and go on with the present chunk; None if there is nothing to decide."""
        with self._commitment.journal.stage("tick"):
            if not self._watch() or self._chunk is None or self._next > self._soonest + STEP:
                return None
            return self._advance(self._chunk.times)

    def see(self, scene: Scene, stamp: float | None = None) -> None:
        super().see(scene, stamp)
        self._near = self._commitment.approach_query(scene, self._braking, self.options.clearance)

    @property
    def _clock_tolerance(self) -> float:
        return self.options.clock_tolerance

    @property
    def _soonest(self) -> float:
        return self._commitment.soonest + self.options.lead

    def _abandon(self) -> None:
        self._chunk = None

    def _judge_again(self) -> None:
        if self._commitment.broken():
            self._next = -inf
            self._commitment.stop(self.problem, "the committed motion is no longer clear", lambda _: None)

    def _rehearse(self) -> None:
        commitment, at = self._commitment, self._soonest
        if commitment.world.stale(at):
            return
        shares = np.linspace(0.1, 1.0, 10)
        targets = commitment.state(at)[0] + REHEARSED * shares[:, None]
        chunk = ActionChunk.following(None, targets, at + shares)
        self._proven(chunk, at)
        nearest = self._nearest(chunk, commitment.state(at), at)
        if nearest is not None:
            commitment.guard.proven(nearest, commitment.world, at)

    def _advance(self, times: Floats) -> Decision:
        chunk, commitment = self._chunk, self._commitment
        assert chunk is not None
        at = max(self._next, self._soonest)
        # A target that is nearly due would be reached with a jerk.
        rest = chunk.after(at + STEP / 4.0)
        if not len(rest.times):
            self._chunk = None
            late = at - float(chunk.times[-1])
            return self._stopped(
                f"no action is left: the last is due {late:.3g} s before a motion can begin", times
            )
        if commitment.stale(at):
            return self._stopped(commitment.world.stale(at), times)
        found, reason = self._proven(rest, at)
        if found is None:
            return self._stopped(reason, times)
        if refused := commitment.offer(found.motion, at):
            return self._stopped(refused, times)
        commitment.satisfies_all(commitment.guard)
        return self._committed(found, reason, at, times)

    def _proven(self, rest: ActionChunk, at: float) -> tuple[_Found | None, str]:
        """Return the proven motion that follows most of the actions, and the reason why not all of them."""
        commitment, limits, reason = self._commitment, self._braking.limits, ""
        guard, world, state = commitment.guard, commitment.world, commitment.state(at)
        motion, count, rate = self._within_limits(rest, state, at)
        while count:
            first = motion.first(count, limits)
            # Most motions are clear: points are measured before a proof only after one that is not.
            contact = self._near.contact(first, world.clock(at)) if reason else inf
            if contact == inf:
                verdict = guard.verdict(first, world, at)
                if verdict.verified:
                    return _Found(_outcome(motion, count, rate, rest), first, motion.chunk, count), reason
                reason, contact = (
                    reason or _why(verdict),
                    inf if verdict.contact is None else verdict.contact.time,
                )
                if contact <= INSTANT:  # so is every motion that begins there
                    return None, reason
            count //= 2
            while (
                count and motion.times[motion.due[count - 1]] >= contact
            ):  # it is on the way to these actions, too
                count //= 2
        nearest = self._nearest(rest, state, at)
        if nearest is None:
            return None, reason or "no motion within the limits of the joints follows the actions"
        verdict = guard.verdict(nearest, world, at)
        if verdict.verified:
            return _Found(ActionOutcome.PROJECTED, nearest, rest, 0), reason
        return None, _why(verdict)

    def _within_limits(self, rest: ActionChunk, state: Floats, at: float) -> tuple[ActionMotion, int, float]:
        found, limits = list[tuple[ActionMotion, int, float]](), self._braking.limits
        # An action beyond a position limit must not bend the motion along those before it.
        inside = rest.up_to(limits) or rest
        deviations = quick_enough(DEVIATIONS, float(inside.times[-1]) - at, limits)
        for rate in RATES:
            followed = inside if rate == 1.0 else inside.slowed(at, rate)
            motion = along_actions(state, at, followed, deviations, limits)
            whole = rest if rate == 1.0 else rest.slowed(at, rate)
            found.append((replace(motion, chunk=whole), motion.within, rate))
            if motion.within == len(inside.times):
                break
        return max(found, key=lambda each: each[1])

    def _nearest(self, rest: ActionChunk, state: Floats, at: float) -> Trajectory | None:
        """Return the motion of the servo that follows the actions; None if it would stay at rest.

        It approaches obstacles only as fast as the robot can stop. The velocities follow the interpolated
        actions with the rate k = 1 / (4 T), where T is the delay of the joints: they do not overshoot.
        """
        braking, limits = self._braking, self._braking.limits
        states = [state]
        for step in range(STEPS):
            here, time = states[-1], at + step * STEP
            lower, upper = braking.bounds(here)
            near = self._near.limits(here, time - self.world.stamp, (lower, upper))
            target, slope = rest.target(time)
            wanted = slope + (target - here[0]) / (4.0 * float(braking.delay.max()))
            settled = settle(joint_task(wanted, braking), near, lower, upper, limits)
            if settled is None:
                return None
            states.append(braking.after(here, settled))
        if max(np.abs(each[1:]).max() for each in states) <= REST:
            return None
        times: Floats = np.linspace(0.0, STEP * STEPS, STEPS + 1)
        return stop_at_the_end(times, np.stack(states, axis=1), limits)

    def _committed(self, driven: _Found, reason: str, at: float, times: Floats) -> Decision:
        outcome, chunk, count = driven.outcome, driven.chunk, driven.count
        self._chunk = None if count == len(chunk.times) else chunk
        self._next = float(chunk.times[count - 1]) if count else at + STEP * STEPS
        if outcome is not ActionOutcome.AS_GIVEN:
            reason = reason or "the actions exceed the limits of the joints"
            self._commitment.journal.note_unless_latest(EventKind.SLOWING, reason)
        commanded = self._positions(times)
        off = np.abs(commanded[-len(chunk.times) :] - chunk.targets)[:count].max(axis=1)
        unchanged = 0 if outcome is ActionOutcome.SLOWED else int((off <= SAME).sum())
        return Decision(outcome, reason, unchanged, commanded)

    @property
    def _failure(self) -> str:
        latest = next((event.words for event in reversed(self.events) if event.kind in FAILURES), "")
        return f"the robot does not follow: {latest}; clear the fault and create another guard"

    def _stopped(self, reason: str, times: Floats) -> Decision:
        self._commitment.journal.note_unless_latest(EventKind.STOPPING, reason)
        return Decision(ActionOutcome.STOPPED, reason, 0, self._positions(times))

    def _positions(self, times: Floats) -> Floats:
        return self._commitment.motion.positions(times)[:, self._commitment.columns]


def _outcome(motion: ActionMotion, count: int, rate: float, actions: ActionChunk) -> ActionOutcome:
    if rate < 1.0:
        return ActionOutcome.SLOWED
    if count < len(actions.times):
        return ActionOutcome.SHORTENED
    off = np.abs(motion.states[0, motion.due] - actions.targets).max()
    return ActionOutcome.AS_GIVEN if off <= SAME else ActionOutcome.SMOOTHED


def _why(verdict: Verdict) -> str:
    contact = verdict.contact
    if contact is None:
        assert verdict.failed is not None
        return f"the motion is not proven to keep {KEPT.get(verdict.failed, 'the clearances')}"
    bodies = f"{contact.first} and {contact.second}"
    return f"{bodies} would be too near to each other at {contact.time:.2f} s of the motion"


def _wrong_number(name: str, count: int) -> str:
    if count > MOST_ACTIONS:
        return f"{name}: there are {count}, more than {MOST_ACTIONS}"
    return "" if count else f"{name}: there are none"
