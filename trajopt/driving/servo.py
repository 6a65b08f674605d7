"""Servo: a robot that is led by hand, command by command, clear of everything and always able to stop."""

import time
from dataclasses import dataclass, field

import numpy as np

from trajopt.driving.commit_loop import off_track, outside_limits
from trajopt.driving.committed_motion import REST, CommittedMotion
from trajopt.driving.events import Event, EventKind
from trajopt.driving.executor import Executor
from trajopt.driving.motion_guard import MotionGuard, guard_of, start_from
from trajopt.driving.options import on_clock
from trajopt.driving.servo_command import Command, Pose, ServoOptions, Twist
from trajopt.driving.servo_program import ApproachLimits, Braking, Surroundings, settle
from trajopt.driving.servo_task import Tool, in_world, joint_task, twist_to, values_of
from trajopt.driving.soonest_stop import soonest_stop, why_unproven
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.optimise.methods.timing import with_jerk
from trajopt.problem.problem import Problem
from trajopt.scene.reduced import reduce_model, tool_frame
from trajopt.scene.scene import Scene
from trajopt.timing.joint_stops import stop_after
from trajopt.values.arrays import Floats, Printed, number
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory

DEFAULT = ServoOptions()
ROUNDING = 1e-9
"""Times nearer than this are one [s]."""
REHEARSED = Twist(np.array((0.01, 0.0, 0.0)))
"""What is rehearsed before anything is commanded: any that moves a tool."""


@checked
@dataclass(eq=False)
class Servo(Printed):
    """Drives a robot as it is told at this very moment: a velocity of its tool or its joints, or a placement.

    What the executor has to drive is at all times: the motion for a tick, and then a stop, proven as one
    motion in the world as it was known. Each tick finds the joints' velocities that follow the command best,
    of those that keep all limits and come nearer to things and to singularities only as fast as can be
    stopped, and splices that and a stop in where the last stop would begin. What is not proven is not spliced
    in, and the robot stops as it was proven before; so it does where no tick or no command comes any more.

    Attributes:
        executor: What drives the robot.
        problem: The robot, its group and surroundings, its limits, and what is required all the way; its goal
            counts for nothing.
        options: Numbers to work with.
        frame: The tool that twists and placements are of; when empty the group's own.
        events: What happened, in order.
        seconds: CPU time of each tick [s].
    """

    executor: Executor
    problem: Problem
    options: ServoOptions = DEFAULT
    frame: str = ""
    events: list[Event] = field(default_factory=list[Event])
    seconds: list[float] = field(default_factory=list[float])
    _seen: WorldSnapshot = field(init=False)
    _guard: MotionGuard = field(init=False)
    _braking: Braking = field(init=False)
    _around: Surroundings = field(init=False)
    _committed: CommittedMotion = field(init=False)
    _command: tuple[Command, float] | None = field(default=None, init=False)
    _filtered: Floats = field(default_factory=lambda: np.zeros(0), init=False)
    _next: float = field(default=-np.inf, init=False)
    _speed: float = field(default=1.0, init=False)
    _revise: bool = field(default=False, init=False)

    def __post_init__(self) -> None:
        """Take the robot as it stands.

        Raises:
            ProblemError: If the robot moves.
            JointNotFound: If the executor does not drive a joint of the group.
            FrameNotFound: If there is no such tool.
        """
        state = self.executor.state()
        if np.abs(state.velocities).max() > REST:
            raise ProblemError("the robot moves: a servo takes it over where it stands")
        self._guard = guard_of(self.problem, self.executor)
        if outside := outside_limits(self._guard.problem, self.executor):
            self._note(EventKind.OUTSIDE_LIMITS, outside)
        self.frame = self.frame or tool_frame(self.problem.reduced)
        self.problem.reduced.attachment(self.frame)
        self._committed = CommittedMotion(self.executor.joint_names, state.commanded)
        self._braking = Braking(with_jerk(self.problem.limits), self.options.period)
        self._look(WorldSnapshot(self.problem.scene, self.executor.now()))
        self._rehearse()

    @property
    def scene(self) -> Scene:
        """The world as it was last told."""
        return self._seen.scene

    @property
    def seen(self) -> WorldSnapshot:
        """The world as it was last told, and when."""
        return self._seen

    @property
    def committed(self) -> CommittedMotion:
        """What the robot will do whatever comes; not to be changed."""
        return self._committed

    @property
    def intended(self) -> None:
        """A servo is on its way to nowhere."""
        return

    @property
    def moving(self) -> bool:
        """Whether the robot has to move now, or will have to."""
        return self.executor.now() < self._committed.end

    @checked
    def command(self, command: Command, stamp: float | None = None) -> None:
        """Say what the robot is to do from the next tick on, until something else is said or the time is out.

        Args:
            command: What it is to do.
            stamp: When it was said, on the executor's clock [s]; now when None.

        Raises:
            ClockError: If the stamp is ahead of the executor's clock by more than `clock_tolerance`; the
                command before it stands then, until its time is out.
            JointNotFound: If a joint is not the group's.
            FrameNotFound: If there is no such frame.
        """
        said = on_clock(stamp, self.executor.now(), self.options.clock_tolerance)
        values = values_of(command, self.problem.reduced, self.options)
        if isinstance(command, Twist):
            self.problem.reduced.attachment(command.frame)
        if self._command is None or not _alike(self._command[0], command):
            self._filtered = np.zeros(len(values))
        self._command = command, said

    @checked
    def release(self, why: str) -> None:
        """Say that nobody leads it any more: from the next tick on it does its stop.

        Args:
            why: For the events, in words.
        """
        if self._command is not None:
            self._command = None
            self._note(EventKind.STOPPING, why)

    @checked
    def slow_to(self, factor: float) -> None:
        """Follow commands at a part of their speed from the next tick on.

        Args:
            factor: From 0 to 1.

        Raises:
            ProblemError: If it is not.
        """
        if not 0.0 <= number("factor", factor) <= 1.0:
            raise ProblemError(f"factor is from 0 to 1, is {factor:g}")
        self._speed = factor

    @checked
    def see(self, scene: Scene, stamp: float | None = None) -> None:
        """Tell it what the world is like; the next tick judges by it what is committed.

        Args:
            scene: Its clock shows 0 at the time of the stamp.
            stamp: On the executor's clock [s]; now when None.

        Raises:
            ClockError: If the stamp is ahead of the executor's clock by more than `clock_tolerance`.
            ProblemError: If it is a scene of another robot. Nothing is changed in either case.
        """
        stated = on_clock(stamp, self.executor.now(), self.options.clock_tolerance)
        self._look(self._seen.followed_by(scene, stated))
        self._revise = True
        self._note(EventKind.WORLD_CHANGED)

    def tick(self) -> None:
        """Watch the robot, and prove and commit what follows the command for the next tick."""
        begun = time.thread_time()
        if not self._failed():
            if self._revise:
                self._revise = False
                self._look_again()
            self._follow()
        self.seconds.append(time.thread_time() - begun)

    def _rehearse(self) -> None:
        """Find and prove a tick's motion, and drive nothing: so the first takes no longer than the others."""
        at = self.executor.now() + self.executor.latency
        self._guard.prepare(self._seen)
        if self._seen.stale(at):
            return
        self._filtered = np.zeros(6)
        motion = self._motion(REHEARSED, self._committed(at)[:, self._columns], at)
        self._filtered = np.zeros(6)
        if motion is not None:
            self._guard.proven(motion, self._seen, at)

    def _follow(self) -> None:
        """Commit the next tick's motion and a stop after it; without one, the robot is left to its stop."""
        now, period = self.executor.now(), self.options.period
        if self._command is None:
            return
        command, said = self._command
        if now - said > self.options.timeout:
            self._command = None
            self._note(EventKind.STOPPING, f"no command for {now - said:.3f} s")
            return
        soonest = now + self.executor.latency
        if self._next > soonest + 2.0 * period - ROUNDING:
            return  # ticks come faster than they should
        # One tick of slack, so that one that comes a little late goes on without braking.
        at = self._next if self._next >= soonest - ROUNDING else soonest + period
        at = max(at, soonest)
        stale = self._seen.stale(at)
        if stale:
            self._once(EventKind.STALE, stale)
            return
        state = self._committed(at)[:, self._columns]
        motion = self._motion(command, state, at)
        if motion is None:
            return
        if not self._guard.proven(motion, self._seen, at):
            self._once(EventKind.STOPPING, "what follows the command is not proven to keep clear")
        elif self._splice(motion, at):
            self._next = at + period

    def _motion(self, command: Command, state: Floats, at: float) -> Trajectory | None:
        """Return a tick's motion and a stop; None where the robot stands and stays, or nothing is found."""
        braking, period = self._braking, self.options.period
        clock = at - self._seen.stamp
        lower, upper = braking.bounds(state)
        near = self._around.approach(state, clock, (lower, upper))
        if isinstance(command, Twist | Pose):
            # The velocities that are asked for are had in the middle of the tick after this one.
            then = state[0] + 1.5 * period * state[1]
            places, joints = self._around.positions(then, clock), len(then)
            tool = Tool.at(self._around.query, places, self.frame, joints)
            twist = self._twist(command, tool)
            task = tool.task(twist)
            singular = tool.approach(twist, braking, state[1]).that_can_break(lower, upper)
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
        then = np.clip(braking.acceleration(state, settled), -limits.acceleration, limits.acceleration)
        q, v, a = state
        end = np.stack(
            (q + period * (v + period * (2.0 * a + then) / 6.0), v + period * (a + then) / 2.0, then)
        )
        return stop_after(state, end, period, limits)

    def _twist(self, command: Twist | Pose, tool: Tool) -> Floats:
        """Return the twist in the world that a command asks of the tool."""
        if isinstance(command, Pose):
            delay = self.executor.latency + float(self._braking.delay.max())
            twist = twist_to(command.target, tool.placement(self.frame), self.options, delay)
        else:
            twist = in_world(self._low_pass(command), tool.placement(command.frame))
        return self._speed * twist

    def _low_pass(self, command: Command) -> Floats:
        values = values_of(command, self.problem.reduced, self.options)
        self._filtered = self._filtered + self.options.taken * (values - self._filtered)
        return self._filtered

    def _look(self, seen: WorldSnapshot) -> None:
        """Take the world as it is seen."""
        self._seen = seen
        problem = self.problem
        kept = self.options.clearance + self._guard.options.distance_error
        reduced = reduce_model(seen.scene, problem.group, problem.start_positions)
        self._around = Surroundings(reduced, self._braking, kept)

    def _look_again(self) -> None:
        """Judge what is committed in the world as it is known now, and stop where it does not hold."""
        at = self.executor.now() + self.executor.latency
        ahead = self._committed.ahead(at, self.problem.reduced.joint_names)
        if ahead is None or self._proven(ahead, at):
            return
        here = np.array(self.problem.start_positions)
        here[self.problem.scene.robot.index(self.executor.joint_names)] = self._committed(at)[0]
        # How hard joints may brake does not depend on the scene, of which nothing may be known any more.
        standing = start_from(self.problem, self.scene.robot.followed(here), self.problem.scene)
        motion, taken = soonest_stop(self._guard, self._seen, at, standing, ahead, None)
        if motion is not ahead:
            self._splice(motion, at)
        self._note(
            EventKind.STOPPING, f"what it was to do is not clear; at rest in {1e3 * taken.duration:.0f} ms"
        )
        if not taken.proven:
            self._note(EventKind.UNPROVEN_STOP, why_unproven(self._guard, self._seen, at, motion))

    def _proven(self, motion: Trajectory, at: float) -> bool:
        return not self._seen.stale(at) and self._guard.proven(motion, self._seen, at)

    def _failed(self) -> bool:
        """Whether the robot does not follow; nothing is commanded then."""
        fault = self.executor.fault()
        if fault:
            self._once(EventKind.FAULT, fault)
        else:
            off = off_track(self.executor, self._committed, self.scene.robot)
            if not off:
                return False
            self._note(EventKind.OFF_TRACK, off)
            self.executor.stop()
        self._command = None
        return True

    @property
    def _columns(self) -> list[int]:
        """Where the group's joints are among those that are driven."""
        return [self.executor.joint_names.index(name) for name in self.problem.reduced.joint_names]

    def _splice(self, motion: Trajectory, at: float) -> bool:
        refused = self.executor.splice(motion, at)
        if refused:
            self._once(EventKind.REJECTED, refused)
            return False
        self._committed.splice(motion, at, now=self.executor.now())
        return True

    def _once(self, kind: EventKind, words: str) -> None:
        """Note what may last for many ticks only when it begins."""
        if not self.events or self.events[-1].kind is not kind:
            self._note(kind, words)

    def _note(self, kind: EventKind, words: str = "") -> None:
        self.events.append(Event(self.executor.now(), kind, words))


def _alike(one: Command, other: Command) -> bool:
    """Whether what the filter has of a command belongs to another too: the same numbers in the same axes."""
    if isinstance(one, Twist) and isinstance(other, Twist):
        return one.frame == other.frame
    return type(one) is type(other)
