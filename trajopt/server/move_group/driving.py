"""Driving one motion at a time through an executor, with proven stops."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf
from typing import ParamSpec, TypeVar

import numpy as np

from trajopt.driving import Executor, SimulatedExecutor
from trajopt.driving.committed_motion import CommittedMotion
from trajopt.driving.motion_guard import MotionGuard, guard_of
from trajopt.driving.soonest_stop import StopTaken, soonest_stop
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.planning import on_the_way
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import joint_positions
from trajopt.robot.joints import JointLimits
from trajopt.robot.robot import Robot
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.server.move_group.outcome import Execution
from trajopt.timing.time_scaling import StopsAlong
from trajopt.values.arrays import Floats, readonly
from trajopt.values.errors import JointNotFound, ProblemError
from trajopt.values.trajectory import MEETING, Interpolation, Trajectory

SETTLING = 0.3
STILL = 1e-6
"""Joint speed that counts as rest [rad/s | m/s]."""
POLL = 0.01
"""Interval of checks whether a motion has ended [s]."""
OFFERS = 4
"""Offers of a motion to an executor that refuses it, each later."""
SHORTEST = 0.05
"""Shortest duration of a correction of the start [s]: many periods of a controller."""
SAMPLES = 200
"""Times at which a foreign motion is compared with the limits."""


@dataclass(frozen=True, eq=False)
class _Motion:
    reduced: ReducedModel
    trajectory: Trajectory
    begin: float
    stops: StopsAlong
    world: WorldSnapshot


class MotionDriver:
    """Drives a robot along motions, one at a time."""

    def __init__(
        self, robot: Robot, executor: Executor, positions: Floats, wait: Callable[[float], object]
    ) -> None:
        for name in executor.joint_names:
            if name not in robot.joint_names:
                raise JointNotFound("joint", name, robot.joint_names)
        self.robot, self.executor = robot, executor
        self._wait, self._others = wait, positions
        self._columns = robot.index(executor.joint_names)
        self._motion: _Motion | None = None
        self._committed = self._standing()

    @property
    def positions(self) -> Floats:
        return self._all(self.executor.state().positions)

    @property
    def moving(self) -> bool:
        """Whether a motion is in progress."""
        executor = self.executor
        return self._motion is not None and executor.now() < self._committed.end and not executor.fault()

    def start(self, reduced: ReducedModel, trajectory: Trajectory) -> str:
        """Start to drive a motion; return immediately, with the reason why it is not driven, or ""."""
        executor = self.executor
        if fault := executor.fault():
            return f"the robot has a fault: {fault}; world.executor.clear_fault() lets it go on"
        self._committed = self._standing()
        here = self._committed(executor.now())[0]
        names = executor.joint_names
        if missing := [name for name in trajectory.joint_names if name not in names]:
            return f"{missing[0]} is not driven here"
        columns = [names.index(name) for name in trajectory.joint_names]
        motion = from_place(with_rates(trajectory), here[columns], reduced.limits)
        lead, refused = 0.0, ""
        for _ in range(OFFERS):
            begun = executor.now()
            at = begun + executor.latency + lead
            refused = executor.splice(motion, at)
            if not refused:
                self._committed.splice(motion, at, now=begun)
                stops = StopsAlong(motion, at_least(reduced.limits, motion))
                self._motion = _Motion(reduced, motion, at, stops, WorldSnapshot(reduced.scene, at))
                break
            lead = 2.0 * (lead + executor.now() - begun) + executor.period
        return refused

    def see(self, scene: Scene) -> str:
        """Take a changed world, whose clock shows 0 now; return which contact is ahead in it, or ""."""
        motion, now = self._motion, self.executor.now()
        if motion is None or not self.moving:
            return ""
        world = WorldSnapshot(scene, now)
        reduced = reduce_model(scene, motion.reduced.group, self.positions)
        self._motion = motion = replace(motion, reduced=reduced, world=world)
        begin = now + self.executor.latency
        ahead = self._committed.ahead(begin, motion.trajectory.joint_names)
        if ahead is None:
            return ""
        # A motion of unknown origin need not be within the limits: contact alone ends it.
        verdict = MotionGuard(self._onward(motion, begin, ahead), {}).verdict(ahead, world, begin)
        met = verdict.contact
        if met is None:
            return ""
        return f"the scene changed: {met.first} and {met.second} would be too near in {met.time:.2f} s"

    def wait(self) -> str:
        executor = self.executor
        while self.moving:
            self._wait(max(POLL, self._committed.end - executor.now()))
        until = executor.now() + SETTLING
        while executor.now() < until and np.abs(executor.state().velocities).max() > STILL:
            self._wait(POLL)
        self._motion = None
        return executor.fault()

    def stop(self) -> StopTaken | None:
        motion, executor = self._motion, self.executor
        if motion is None or not self.moving:
            return None
        asked, lead = executor.now(), 0.0
        for _ in range(OFFERS):
            begun = executor.now()
            begin = begun + executor.latency + lead
            ahead = self._committed.ahead(begin, motion.trajectory.joint_names)
            if ahead is None:
                return self._rested(asked, StopTaken(0.0, along=True, proven=True))
            stop, taken = self._soonest(motion, begin, ahead)
            refused = "" if stop is ahead else executor.splice(stop, begin)
            if not refused:
                if stop is not ahead:
                    self._committed.splice(stop, begin, now=begun)
                return self._rested(asked, taken)
            lead = 2.0 * (lead + executor.now() - begun) + executor.period
        # Whoever asks for a stop gets one: in the driver's own way, which nobody has proven.
        executor.stop()
        return self._rested(asked, StopTaken(0.0, along=False, proven=False))

    def _rested(self, asked: float, taken: StopTaken) -> StopTaken:
        end = max(self._committed.end, asked) if not self.executor.fault() else self.executor.now()
        self.wait()
        return replace(taken, duration=end - asked)

    def _soonest(self, motion: _Motion, begin: float, ahead: Trajectory) -> tuple[Trajectory, StopTaken]:
        since, along = max(begin - motion.begin, 0.0), ahead
        if since < motion.trajectory.duration and begin >= motion.begin:
            along = motion.stops.earliest(since).trajectory
        problem = self._onward(motion, begin, ahead)
        guard = guard_of(problem, self.executor)
        try:
            limits = on_the_way(problem, ahead, 0.0).limits
            return soonest_stop(guard, motion.world, begin, limits, ahead, along)
        except ProblemError:
            # A motion that is faster than the limits allow can be braked on its path only, and not be proven.
            soonest = min((ahead, along), key=lambda each: each.duration)
            return soonest, StopTaken(soonest.duration, along=True, proven=False)

    def _onward(self, motion: _Motion, begin: float, ahead: Trajectory) -> Problem:
        end = dict(zip(ahead.joint_names, ahead(ahead.duration).tolist(), strict=True))
        return Problem(
            scene=motion.world.scene,
            group=motion.reduced.group,
            start=self._all(self._committed(begin)[0]),
            goal=joint_positions(end),
        )

    def _standing(self) -> CommittedMotion:
        return CommittedMotion(self.executor.joint_names, self.executor.state().commanded)

    def _all(self, driven: Floats) -> Floats:
        positions = np.array(self._others)
        positions[self._columns] = driven
        return self.robot.followed(positions)


class ScriptClock:
    """The clock of a simulated robot: it advances only while a caller waits."""

    def __init__(self) -> None:
        self._shown, self._since = 0.0, inf

    def __call__(self) -> float:
        return self._shown + max(time.monotonic() - self._since, 0.0)

    def run(self) -> None:
        self._shown, self._since = self(), time.monotonic()

    def stand(self) -> None:
        self._shown, self._since = self(), inf

    def skip(self, seconds: float) -> None:
        self._shown += seconds


def with_rates(trajectory: Trajectory) -> Trajectory:
    if trajectory.interpolation is not Interpolation.LINEAR:
        return trajectory
    velocities = np.gradient(trajectory.positions, trajectory.times, axis=0)
    velocities[[0, -1]] = 0.0
    return Trajectory(trajectory.joint_names, trajectory.times, trajectory.positions, velocities)


def from_place(trajectory: Trajectory, here: Floats, limits: JointLimits) -> Trajectory:
    """Return a motion that moves slowly from commanded positions (n,) [rad | m] to a motion's own start."""
    away = np.abs(trajectory.positions[0] - here)
    if away.max() <= MEETING:
        return trajectory
    # A cubic from rest to rest is 1.5 times as fast as on average, its acceleration is 6 times that over the
    # time; a quintic's jerk is 60 times. Half the limits leave room for the begin of the motion.
    times = (
        3.0 * away / limits.velocity,
        np.sqrt(12.0 * away / limits.acceleration),
        np.cbrt(120.0 * away / limits.jerk),
    )
    later = max(SHORTEST, *(float(each.max()) for each in times))
    rates = [rows for rows in (trajectory.velocities, trajectory.accelerations) if rows is not None]
    still = np.zeros((1, len(here)))
    return Trajectory(
        trajectory.joint_names,
        np.append(0.0, trajectory.times + later),
        np.vstack((here, trajectory.positions)),
        *(np.vstack((still, rows)) for rows in rates),
    )


def at_least(limits: JointLimits, trajectory: Trajectory) -> JointLimits:
    """Return limits raised to the motion's own extremes, for braking."""
    times = np.linspace(0.0, trajectory.duration, SAMPLES)
    jerk = np.maximum(limits.jerk, np.abs(trajectory(times, 3)).max(axis=0))
    if trajectory.interpolation is not Interpolation.QUINTIC:
        jerk = np.full(len(jerk), inf)
    return replace(
        limits,
        velocity=readonly(np.maximum(limits.velocity, np.abs(trajectory(times, 1)).max(axis=0))),
        acceleration=readonly(np.maximum(limits.acceleration, np.abs(trajectory(times, 2)).max(axis=0))),
        jerk=readonly(jerk),
    )


P = ParamSpec("P")
R = TypeVar("R")


class InProcess:
    """Plans for a world and moves its robot, in this process; the world answers all other queries."""

    def __init__(
        self, scene: Scene, start: Floats, executor: Executor | None, wait: Callable[[float], object]
    ) -> None:
        self.robot: Robot = scene.robot
        self.scene, self._start = scene, start
        self._clock: ScriptClock | None = None
        self._drive = None if executor is None else MotionDriver(self.robot, executor, start, wait)

    @property
    def positions(self) -> Floats:
        """Positions of all joints, shape (number of joints,) [rad | m]."""
        return self._start if self._drive is None else self._drive.positions

    @property
    def moving(self) -> bool:
        """Whether a motion is in progress."""
        moving = self._drive is not None and self._drive.moving
        if not moving and self._clock is not None:
            self._clock.stand()
        return moving

    @property
    def executor(self) -> Executor:
        """Executor that drives the joints."""
        return self._driving().executor

    def stand(self, positions: Floats) -> None:
        """Set the positions of all joints, shape (number of joints,) [rad | m]."""
        self._start = positions

    def take(self, scene: Scene) -> None:
        """Replace the scene around the robot."""
        self.scene = scene

    def ask(self, function: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
        """Call a function of `trajopt.server.move_group.functions`."""
        return function(*args, **kwargs)

    def begin(self, execution: Execution, *, paced: bool) -> str:
        """Start a motion and return immediately, with the reason if it cannot start, else empty.

        Args:
            paced: Whether simulated time passes in real time, since the script does not wait for the end.
        """
        drive, trajectory = self._driving(), execution.trajectory
        executor = drive.executor
        if self._clock is not None and isinstance(executor, SimulatedExecutor):
            begin = executor.now() + executor.latency
            executor.change(execution.reduced.scene, begin=begin, duration=trajectory.duration)
        refused = drive.start(execution.reduced, trajectory)
        if paced and not refused and self._clock is not None:
            self._clock.run()
        return refused

    def wait(self) -> str:
        """Wait until the robot is at rest; return the fault, or an empty text."""
        drive = self._driving()
        remarks, executor = [drive.wait()], drive.executor
        if self._clock is not None and isinstance(executor, SimulatedExecutor):
            remarks += mishaps_of(executor)
        return "; ".join(remark for remark in remarks if remark)

    def stop(self) -> StopTaken | None:
        """Stop the robot as soon as a proven stop allows; None if it is at rest."""
        if self._clock is not None:
            self._clock.stand()
        return None if self._drive is None else self._drive.stop()

    def close(self) -> None:
        """Keep everything: the world may be entered again."""

    def _driving(self) -> MotionDriver:
        if self._drive is None:
            self._clock = ScriptClock()
            simulated = SimulatedExecutor(self.scene, self._start, clock=self._clock)
            self._drive = MotionDriver(self.robot, simulated, self._start, self._clock.skip)
        return self._drive


def mishaps_of(executor: SimulatedExecutor) -> list[str]:
    contacts = [str(contact) for contact in executor.contacts if contact.allowance is None]
    return [*contacts, *(f"the motor of {joint} was at its limit" for joint in executor.saturated)]
