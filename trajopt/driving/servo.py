"""Servo: drives a robot by velocity or pose commands."""

from dataclasses import dataclass, field

import numpy as np

from trajopt.driving.commit_loop import CommitLoop, refuse_rolling
from trajopt.driving.committed_motion import REST
from trajopt.driving.events import EventKind
from trajopt.driving.servo_command import Command, Pose, ServoOptions, Twist
from trajopt.driving.servo_program import ApproachLimits, ApproachQuery, Braking, settle
from trajopt.driving.servo_task import Tool, in_world, joint_task, twist_to, values_of
from trajopt.optimise.methods.timing import with_jerk
from trajopt.scene.reducing import tool_frame
from trajopt.scene.scene import Scene
from trajopt.timing.time_scaling import stop_after
from trajopt.values.arrays import Floats, number
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked_class
from trajopt.values.trajectory import Trajectory
from trajopt.verify.checks.torques import TorqueCriterion
from trajopt.verify.specification import Verdict

DEFAULT = ServoOptions()
ROUNDING = 1e-9
"""Times closer than this are equal [s]."""
REHEARSED = Twist(np.array((0.01, 0.0, 0.0)))
"""Command of the rehearsal before the first tick: any that moves a tool."""
LEAST_SHARE = 1.0 / 64.0
"""Smallest share of the acceleration limits tried if motors are too weak for more; below, gravity alone is
too much for them.
"""


@checked_class
@dataclass(eq=False)
class Servo(CommitLoop):
    """Drives a robot by the present command: a velocity of its tool or joints, or a pose of its tool.

    Each tick finds the joint velocities that follow the command best within all limits, approaching obstacles
    and singularities only as fast as the robot can stop. Accelerations that are too much for the motors are
    halved until the next command after none.

    Attributes:
        problem: Robot, group, scene, limits and path constraints; its goal does not count.
        frame: Tool of twists and poses; the group's own if empty.
    """

    options: ServoOptions = DEFAULT
    frame: str = ""
    _braking: Braking = field(init=False)
    _near: ApproachQuery = field(init=False)
    _command: tuple[Command, float] | None = field(default=None, init=False)
    _filtered: Floats = field(default_factory=lambda: np.zeros(0), init=False)
    _next: float = field(default=-np.inf, init=False)
    _speed: float = field(default=1.0, init=False)
    _share: float = field(default=1.0, init=False)
    _first_share: float = field(default=1.0, init=False)

    def __post_init__(self) -> None:
        refuse_rolling(self.problem)
        super().__post_init__()
        self.frame = self.frame or tool_frame(self.problem.reduced)
        self.problem.reduced.attachment(self.frame)
        self._limit_accelerations(1.0)
        self._rehearse()
        self._first_share = self._share

    @property
    def seconds(self) -> list[float]:
        return self._commitment.journal.seconds.setdefault("tick", [])

    def command(self, command: Command, stamp: float | None = None) -> None:
        """Follow a command from the next tick until another one or the timeout.

        Raises:
            ClockError: If the stamp is ahead of the executor's clock by more than `clock_tolerance`; the last
                command then stays until its timeout.
            JointNotFound: If a joint does not belong to the group.
            FrameNotFound: If the frame does not exist.
        """
        stated = self._on_clock(stamp)
        values = values_of(command, self.problem.reduced, self.options)
        if isinstance(command, Twist):
            self.problem.reduced.attachment(command.frame)
        if self._command is None or not _same_axes(self._command[0], command):
            self._filtered = np.zeros(len(values))
        if self._command is None and self._share < self._first_share:
            self._limit_accelerations(self._first_share)  # the arm may be where its motors can do more
        self._command = command, stated

    def release(self, why: str) -> None:
        """Stop: from the next tick there is no command; `why` is noted in the event."""
        if self._command is not None:
            self._command = None
            self._commitment.journal.note(EventKind.STOPPING, why)

    def slow_to(self, factor: float) -> None:
        """Follow commands at a share of their speed, 0 to 1, from the next tick."""
        if not 0.0 <= number("factor", factor) <= 1.0:
            raise ProblemError(f"factor must be from 0 to 1, is {factor:g}")
        self._speed = factor

    def see(self, scene: Scene, stamp: float | None = None) -> None:
        super().see(scene, stamp)
        self._near = self._commitment.approach_query(scene, self._braking, self.options.clearance)

    def tick(self) -> None:
        """Watch the robot, and prove and commit the motion of the next tick."""
        with self._commitment.journal.stage("tick"):
            if self._watch():
                self._follow()

    @property
    def _clock_tolerance(self) -> float:
        return self.options.clock_tolerance

    def _abandon(self) -> None:
        self._command = None

    def _rehearse(self) -> None:
        commitment, at = self._commitment, self._commitment.soonest
        commitment.guard.prepare(commitment.world)
        if commitment.world.stale(at):
            return
        while True:
            self._filtered = np.zeros(6)
            motion = self._motion(REHEARSED, commitment.state(at), at)
            self._filtered = np.zeros(6)
            if motion is None or not self._eased(commitment.guard.verdict(motion, commitment.world, at)):
                return

    def _limit_accelerations(self, share: float) -> None:
        limits = self.problem.limits.scaled(velocity=1.0, acceleration=share)
        self._share = share
        self._braking = Braking(with_jerk(limits), self.options.period)
        self._near = self._commitment.approach_query(self.scene, self._braking, self.options.clearance)

    def _eased(self, verdict: Verdict) -> bool:
        """Halve the accelerations if motors are too weak for a motion; return whether that was possible."""
        if verdict.failed is not TorqueCriterion or self._share <= LEAST_SHARE:
            return False
        self._limit_accelerations(self._share / 2.0)
        return True

    def _follow(self) -> None:
        commitment, now, period = self._commitment, self.executor.now(), self.options.period
        if self._command is None:
            return
        command, stated = self._command
        if now < stated:
            self._command = None
            commitment.journal.note(EventKind.STOPPING, "the executor's clock was set back")
            return
        if now - stated > self.options.timeout:
            self._command = None
            commitment.journal.note(EventKind.STOPPING, f"no command for {now - stated:.3f} s")
            return
        soonest = now + self.executor.latency
        if self._next > soonest + 2.0 * period - ROUNDING:
            return  # the ticks are too fast
        # One tick of slack, so that a slightly late one goes on without braking.
        at = self._next if self._next >= soonest - ROUNDING else soonest + period
        at = max(at, soonest)
        if commitment.stale(at):
            return
        motion = self._motion(command, commitment.state(at), at)
        if motion is None:
            return
        guard, journal = commitment.guard, commitment.journal
        verdict = guard.verdict(motion, commitment.world, at)
        if not verdict.verified:
            if not self._eased(verdict) and not journal.latest_is(EventKind.STOPPING):
                why = guard.failed_check(motion, commitment.world, at)
                journal.note(EventKind.STOPPING, f"the motion that follows the command is not proven: {why}")
        elif refused := commitment.offer(motion, at):
            journal.note_unless_latest(EventKind.REJECTED, refused)
        else:
            commitment.satisfies_all(guard)
            self._next = at + period

    def _motion(self, command: Command, state: Floats, at: float) -> Trajectory | None:
        braking, period = self._braking, self.options.period
        clock = at - self.world.stamp
        lower, upper = braking.bounds(state)
        near = self._near.limits(state, clock, (lower, upper))
        if isinstance(command, Twist | Pose):
            # The commanded velocities are reached in the middle of the tick after this one.
            then = state[0] + 1.5 * period * state[1]
            positions, joints = self._near.positions(then, clock), len(then)
            tool = Tool.at(self._near.query, positions, self.frame, joints)
            twist = self._twist(command, tool)
            task = tool.task(twist)
            singular = tool.approach(twist, braking, state[1])
            near = ApproachLimits(
                np.concatenate((near.jacobian, singular.jacobian)),
                np.concatenate((near.lower, singular.lower)),
            )
        else:
            task = joint_task(self._speed * self._low_pass(command), braking)
        limits = braking.limits
        settled = settle(task, near, lower, upper, limits)
        if settled is None:
            return None
        if np.abs(state[1:]).max() <= REST and np.abs(settled).max() <= REST:
            return None
        return stop_after(state, braking.after(state, settled), period, limits)

    def _twist(self, command: Twist | Pose, tool: Tool) -> Floats:
        if isinstance(command, Pose):
            delay = self.executor.latency + float(self._braking.delay.max())
            twist = twist_to(command.target, tool.placement(self.frame), self.options, delay)
        else:
            twist = in_world(self._low_pass(command), tool.placement(command.frame))
        return self._speed * twist

    def _low_pass(self, command: Command) -> Floats:
        values = values_of(command, self.problem.reduced, self.options)
        self._filtered = self._filtered + self.options.filter_gain * (values - self._filtered)
        return self._filtered


def _same_axes(one: Command, other: Command) -> bool:
    if isinstance(one, Twist) and isinstance(other, Twist):
        return one.frame == other.frame
    return type(one) is type(other)
