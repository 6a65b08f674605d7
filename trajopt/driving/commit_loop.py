"""Commit loop of supervisor and servo."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from trajopt.driving.committed_motion import SETTLED, CommittedMotion
from trajopt.driving.events import Event, EventKind, Journal
from trajopt.driving.executor import Executor
from trajopt.driving.intended_motion import IntendedMotion
from trajopt.driving.motion_guard import MotionGuard, guard_of, start_at
from trajopt.driving.options import on_clock
from trajopt.driving.servo_program import ApproachQuery, Braking
from trajopt.driving.soonest_stop import StopTaken, soonest_stop, why_unproven
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.planning import on_the_way
from trajopt.problem.problem import Problem
from trajopt.robot.joints import joint_unit
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.timing.time_scaling import PathStop
from trajopt.values.arrays import Floats, Printed, Value, floats
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked_class
from trajopt.values.printed import in_joint_position, in_range, in_unit
from trajopt.values.shapes.clouds import Points, Voxels
from trajopt.values.trajectory import Trajectory

ROUNDING = 1e-9
"""A joint outside its limits by less than this is at its limit [rad | m]."""
STOP_ATTEMPTS = 3
"""Searches for a stop. The second begins later by twice the time of the first."""


@dataclass(frozen=True, eq=False)
class CommittedStop(Value):
    """A stop to which a robot is bound."""

    taken: StopTaken
    begin: float
    on_path: PathStop | None = None


@dataclass(eq=False)
class Commitment(Printed):
    """The proven motion to which a robot is bound; it ends at rest.

    Attributes:
        world_changed: Whether the motion has not been judged in this world yet.
        constrained: Whether the motion satisfies the path constraints, unlike some stops and the return to
            the path after them.
        left_path_at: Positions of the driven joints at which a stop left a path that satisfied all
            constraints, shape (n,) [rad | m]; None once such a path is driven again.
    """

    executor: Executor
    journal: Journal
    guard: MotionGuard
    world: WorldSnapshot
    motion: CommittedMotion
    world_changed: bool = False
    constrained: bool = True
    left_path_at: Floats | None = None

    @staticmethod
    def at_rest(executor: Executor, problem: Problem) -> "Commitment":
        """Take over a robot at rest."""
        state, size = executor.state(), len(executor.joint_names)
        for name in ("positions", "velocities", "commanded"):
            floats(f"Executor.state().{name}", getattr(state, name), (size,))
        if np.abs(state.velocities).max() > SETTLED:
            raise ProblemError("the robot is moving; it can be taken over only at rest")
        guard, journal = guard_of(problem, executor), Journal(executor.now)
        if outside := outside_limits(guard.problem, executor):
            journal.note(EventKind.OUTSIDE_LIMITS, outside)
        world = WorldSnapshot(problem.scene, executor.now())
        return Commitment(
            executor, journal, guard, world, CommittedMotion(executor.joint_names, state.commanded)
        )

    @property
    def soonest(self) -> float:
        return self.executor.now() + self.executor.latency

    @property
    def joint_names(self) -> tuple[str, ...]:
        return self.guard.problem.reduced.joint_names

    def state(self, time: float) -> Floats:
        return self.motion(time)[:, self.columns]

    @property
    def columns(self) -> list[int]:
        return [self.executor.joint_names.index(name) for name in self.joint_names]

    def approach_query(self, scene: Scene, braking: Braking, clearance: float) -> ApproachQuery:
        """Return the query of the allowed approach speeds in a scene, with a further clearance [m]."""
        return ApproachQuery(
            self.guard.reduced(scene), braking, clearance + self.guard.options.distance_error
        )

    def reset(self) -> None:
        self.motion = CommittedMotion(self.executor.joint_names, self.executor.state().commanded)
        self.constrained, self.left_path_at = True, None

    def report_world(self, scene: Scene, stamp: float) -> None:
        self.world = self.world.updated(scene, stamp)
        self.world_changed = True
        self.journal.note(EventKind.WORLD_CHANGED)

    def failed(self, *, engaged: bool) -> bool:
        """Return whether the robot does not follow; stop one off its track. Note a fault only if engaged."""
        fault = self.executor.fault()
        self.journal.note_once(EventKind.FAULT, fault if engaged else "")
        if fault:
            return True
        words = off_track(self.executor, self.motion, self.world.scene.robot)
        if words:
            self.journal.note(EventKind.OFF_TRACK, words)
            self.executor.stop()
        return bool(words)

    def broken(self) -> bool:
        begin = self.soonest
        ahead = self.motion.ahead(begin, self.joint_names)
        if ahead is None:
            return False
        return self.stale(begin) or not self.guard.proven(
            ahead, self.world, begin, requirements=self.constrained
        )

    def stale(self, time: float) -> bool:
        words = self.world.stale(time)
        self.journal.note_once(EventKind.STALE, words)
        return bool(words)

    def splice(self, motion: Trajectory, at: float) -> bool:
        refused = self.offer(motion, at)
        if refused:
            self.journal.note(EventKind.REJECTED, refused)
        return not refused

    def offer(self, motion: Trajectory, at: float) -> str:
        refused = self.executor.splice(motion, at)
        if not refused:
            self.motion.splice(motion, at, now=self.executor.now())
        return refused

    def satisfies_all(self, guard: MotionGuard) -> None:
        self.guard, self.constrained, self.left_path_at = guard, True, None

    def planning_scene(self, at: float, world: WorldSnapshot) -> Scene:
        return self.guard.tracked(world.at(at))

    def continued(self, problem: Problem, at: float, world: WorldSnapshot) -> Problem:
        here = self.resting(problem, at, self.planning_scene(at, world))
        ahead = self.motion.ahead(at, self.joint_names)
        return here if ahead is None else on_the_way(here, ahead, 0.0)

    def resting(self, problem: Problem, at: float, scene: Scene) -> Problem:
        return start_at(problem, self.motion, at, scene)

    def stop(
        self, problem: Problem, why: str, path_stop: Callable[[float], PathStop | None]
    ) -> CommittedStop:
        """Commit the robot to the soonest proven stop.

        If the executor refuses the stop because it is late, the search is repeated for a later begin. If no
        stop is accepted, the motors brake.
        """
        lead = 0.0
        for _ in range(STOP_ATTEMPTS):
            asked = self.executor.now()
            begin = self.soonest + lead
            found = self._stop_at(begin, problem, why, path_stop(begin), delayed=lead > 0.0)
            if found is not None:
                return found
            lead = 2.0 * (self.executor.now() - asked)
        return CommittedStop(self._brake(why), self.soonest)

    def _stop_at(
        self, begin: float, problem: Problem, why: str, on_path: PathStop | None, *, delayed: bool
    ) -> CommittedStop | None:
        ahead = self.motion.ahead(begin, self.joint_names)
        if ahead is None:  # at rest by then; a delayed stop would come too late
            return None if delayed else CommittedStop(StopTaken(0.0, along=True, proven=True), begin)
        self.stale(begin + ahead.duration)
        along = None if on_path is None else on_path.trajectory
        motion, taken = soonest_stop(self.guard, self.world, begin, problem.limits, ahead, along)
        if motion is not ahead and not self.splice(motion, begin):
            return None
        if not taken.along and self.left_path_at is None:
            self.left_path_at = self.motion(begin)[0]
        self.constrained = taken.held or not taken.proven
        self.journal.note(EventKind.STOPPING, f"{why}; at rest in {1e3 * taken.duration:.0f} ms")
        if not taken.proven:
            self.journal.note(EventKind.UNPROVEN_STOP, why_unproven(self.guard, self.world, begin, motion))
        return CommittedStop(taken, begin, on_path if motion is along else None)

    def _brake(self, why: str) -> StopTaken:
        ahead = self.motion.ahead(self.soonest, self.joint_names)
        self.executor.stop()
        self.journal.note(EventKind.STOPPING, f"{why}; all motors brake")
        self.journal.note(EventKind.UNPROVEN_STOP, "no proven stop was accepted in time")
        return StopTaken(0.0 if ahead is None else ahead.duration, along=False, proven=False)


@checked_class
@dataclass(eq=False)
class CommitLoop(Printed, ABC):
    """The common part of `Supervisor`, `Servo` and `Guard`.

    Each turn compares the robot with its committed motion, and stops it if that is not proven in a changed
    world.
    """

    executor: Executor
    problem: Problem
    _commitment: Commitment = field(init=False)
    _cloud_stamps: dict[str, float] = field(default_factory=dict[str, float], init=False)

    def __post_init__(self) -> None:
        self._commitment = Commitment.at_rest(self.executor, self.problem)

    @property
    def events(self) -> list[Event]:
        return self._commitment.journal.events

    @property
    def scene(self) -> Scene:
        return self._commitment.world.scene

    @property
    def world(self) -> WorldSnapshot:
        """The world as last reported."""
        return self._commitment.world

    @property
    def committed(self) -> CommittedMotion:
        """The committed motion."""
        return self._commitment.motion

    @property
    def intended(self) -> IntendedMotion | None:
        """The motion to the goal, or None."""
        return None

    @property
    def moving(self) -> bool:
        """Whether a committed motion is in progress."""
        return self.executor.now() < self._commitment.motion.end

    def see(self, scene: Scene, stamp: float | None = None) -> None:
        """Report the world; the next turn judges the committed motion in it. If it raises, nothing changes.

        Args:
            scene: Its clock shows 0 at the time of the stamp.
            stamp: On the executor's clock [s]; now when None.
        """
        self._commitment.report_world(scene, self._on_clock(stamp))

    def see_cloud(self, name: str, cloud: Points | Voxels | None, stamp: float | None = None) -> bool:
        """Replace the cloud of a camera, unless a newer one has arrived; all else stays as reported.

        Raises:
            ClockError: If the stamp is ahead of the executor's clock by more than `clock_tolerance`; later
                images with valid stamps still count.
            ModelError: If the name belongs to the robot, or to an object that is not a cloud.
        """
        measured = self._on_clock(stamp)
        # After the clock was set back, stamps do not order the images: the one that comes counts.
        if measured < self._cloud_stamps.get(name, -np.inf) <= self.executor.now():
            return False
        world = self.world
        self.see(world.scene.with_cloud(name, cloud), world.stamp)
        self._cloud_stamps[name] = measured
        return True

    @property
    @abstractmethod
    def _clock_tolerance(self) -> float:
        """The option `clock_tolerance` [s]."""

    @property
    def _engaged(self) -> bool:
        """Whether the robot has a task."""
        return True

    @abstractmethod
    def _abandon(self) -> None:
        """Drop the task: the robot does not follow."""

    def _judge_again(self) -> None:
        """Judge the committed motion in the changed world, and stop if it is not proven."""
        if self._commitment.broken():
            self._commitment.stop(self.problem, "the committed motion is no longer clear", lambda _: None)

    def _watch(self) -> bool:
        if self._commitment.failed(engaged=self._engaged):
            self._abandon()
            return False
        if self._commitment.world_changed:
            self._commitment.world_changed = False
            self._judge_again()
        return True

    def _on_clock(self, stamp: float | None) -> float:
        return on_clock(stamp, self.executor.now(), self._clock_tolerance)


def refuse_rolling(problem: Problem) -> None:
    """Refuse a group with a rolling base to a loop of short motions: each alone may slip a little."""
    if problem.scene.robot.base.rolling(problem.reduced.joint_names):
        raise ProblemError(
            f"group {shown(problem.group)} moves a base whose wheels roll: the slip of many short motions "
            "would add up; choose a group without the base"
        )


def off_track(executor: Executor, committed: CommittedMotion, robot: Robot) -> str:
    """Describe the joint that is farthest outside the tracking tolerance; empty if none."""
    state = executor.state()
    commanded = committed(state.stamp)[0]
    excess = np.abs(state.positions - commanded) - executor.tolerance
    worst = int(excess.argmax())
    if excess[worst] <= 0.0:
        return ""
    name = executor.joint_names[worst]
    unit = joint_unit(robot.model, name)
    measured, should = (in_joint_position(float(each[worst]), unit) for each in (state.positions, commanded))
    allowed = in_unit(float(executor.tolerance[worst]), unit)
    return f"{name} is at {measured}, has to be at {should} within {allowed}"


def outside_limits(problem: Problem, executor: Executor) -> str:
    """List the joints outside the group that exceed their limits; empty if none."""
    robot, driven = problem.scene.robot, executor.joint_names
    found: list[str] = []
    for name in robot.joint_names:
        outside = "" if name in problem.reduced.moving_joints else joint_outside(problem, name)
        if not outside:
            continue
        held = "stays there"
        if name in driven:
            unit = joint_unit(robot.model, name)
            held = f"is held there within {in_unit(float(executor.tolerance[driven.index(name)]), unit)}"
        elif name in robot.mimics:
            held = f"follows {robot.mimics[name].source}"
        found.append(f"{outside}, and {held}")
    return "; ".join(found)


def joint_outside(problem: Problem, name: str) -> str:
    """Describe by how much a joint starts outside its limits; empty if it is inside."""
    robot = problem.scene.robot
    (index,), limits = robot.index([name]), robot.limits
    lower, upper, here = (
        float(each[index]) for each in (limits.lower, limits.upper, problem.start_positions)
    )
    if lower - ROUNDING <= here <= upper + ROUNDING:
        return ""
    unit = joint_unit(robot.model, name)
    return f"{name} is at {in_joint_position(here, unit)}, outside its limits {in_range(lower, upper, unit)}"
