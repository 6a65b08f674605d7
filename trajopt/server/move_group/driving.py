"""Driving: one motion at a time through an executor, waited for or not, and stopped as soon as is proven."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from trajopt.driving.committed_motion import CommittedMotion
from trajopt.driving.executor import Executor
from trajopt.driving.motion_guard import guard_of, start_from
from trajopt.driving.soonest_stop import StopTaken, soonest_stop
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import joint_positions
from trajopt.robot.limits import JointLimits
from trajopt.robot.robot import Robot
from trajopt.scene.reduced import ReducedModel
from trajopt.timing.stops import StopsAlong
from trajopt.values.arrays import Floats, readonly
from trajopt.values.errors import JointNotFound, ProblemError
from trajopt.values.trajectory import MEETING, Interpolation, Trajectory

SETTLING = 0.3
"""After the end of a motion the robot is waited for, to be where it is told to be, so long at most [s]."""
STILL = 1e-6
"""A joint this slow has come to rest [rad/s | m/s]: sensors with noise take the whole time of settling."""
LOOK = 0.01
"""Time between two looks at whether a motion has ended [s]."""
OFFERS = 4
"""So often a motion is offered to an executor that refuses it, later and later: it took long to make, or what
somebody else gave has a jump of acceleration just where it would be left."""
SHORTEST = 0.05
"""A correction of the place where a robot stands takes at least so long [s]: many periods of a controller."""
SAMPLES = 200
"""Moments at which a motion that somebody gives is compared with the limits."""


@dataclass(frozen=True, eq=False)
class _Motion:
    """A motion under way."""

    reduced: ReducedModel
    trajectory: Trajectory
    begin: float
    stops: StopsAlong


class Drive:
    """Drives a robot along motions, one at a time.

    Attributes:
        robot: The robot.
        executor: What drives its joints.
    """

    def __init__(
        self, robot: Robot, executor: Executor, positions: Floats, wait: Callable[[float], object]
    ) -> None:
        """Take over a robot that stands.

        Args:
            robot: The robot.
            executor: What drives its joints.
            positions: Of all joints, shape (number of joints,) [rad | m]: where those are that it does not
                drive.
            wait: Lets so many seconds pass.

        Raises:
            JointNotFound: If it drives a joint that the robot does not have.
        """
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
        """Where all joints are now, shape (number of joints,) [rad | m]."""
        return self._all(self.executor.state().positions)

    @property
    def moving(self) -> bool:
        """Whether a motion is under way."""
        executor = self.executor
        return self._motion is not None and executor.now() < self._committed.end and not executor.fault()

    def start(self, reduced: ReducedModel, trajectory: Trajectory) -> str:
        """Begin to drive a motion, and return at once.

        Args:
            reduced: The robot in its scene, the group's joints free.
            trajectory: Of the group's joints.

        Returns:
            Why it is not driven; empty if it is.
        """
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
                self._motion = _Motion(reduced, motion, at, stops)
                break
            lead = 2.0 * (lead + executor.now() - begun) + executor.period
        return refused

    def wait(self) -> str:
        """Return when the motion has ended and the robot has come to rest; say what went wrong."""
        executor = self.executor
        while self.moving:
            self._wait(max(LOOK, self._committed.end - executor.now()))
        until = executor.now() + SETTLING
        while executor.now() < until and np.abs(executor.state().velocities).max() > STILL:
            self._wait(LOOK)
        self._motion = None
        return executor.fault()

    def stop(self) -> StopTaken | None:
        """Bring the robot to rest as soon as is proven, and return when it is; None where nothing moves.

        Of a stop along the path and one in which each joint brakes as hard as it may, the sooner one that is
        proven is driven; if none is, the sooner one.
        """
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
        """Wait for the end of a stop; return it with the time since it was asked for."""
        end = max(self._committed.end, asked) if not self.executor.fault() else self.executor.now()
        self.wait()
        return replace(taken, duration=end - asked)

    def _soonest(self, motion: _Motion, begin: float, ahead: Trajectory) -> tuple[Trajectory, StopTaken]:
        """Return the soonest proven stop from a time on."""
        since, reduced = max(begin - motion.begin, 0.0), motion.reduced
        along = ahead
        if since < motion.trajectory.duration and begin >= motion.begin:
            along = motion.stops.earliest(since).trajectory
        end = dict(zip(ahead.joint_names, ahead(ahead.duration).tolist(), strict=True))
        problem = Problem(
            scene=reduced.scene,
            group=reduced.group,
            start=self._all(self._committed(begin)[0]),
            goal=joint_positions(end),
        )
        guard, world = guard_of(problem, self.executor), WorldSnapshot(reduced.scene, motion.begin)
        here = start_from(problem, problem.start_positions, reduced.scene)
        try:
            return soonest_stop(guard, world, begin, here, ahead, along)
        except ProblemError:
            # A motion that is faster than the limits allow can be braked on its path only, and not be proven.
            soonest = min((ahead, along), key=lambda each: each.duration)
            return soonest, StopTaken(soonest.duration, along=True, proven=False)

    def _standing(self) -> CommittedMotion:
        return CommittedMotion(self.executor.joint_names, self.executor.state().commanded)

    def _all(self, driven: Floats) -> Floats:
        positions = np.array(self._others)
        positions[self._columns] = driven
        return self.robot.followed(positions)


class ScriptClock:
    """The clock of a simulated robot: it stands while nothing moves, and is put forward by who waits."""

    def __init__(self) -> None:
        """Show 0 and stand."""
        self._shown, self._since = 0.0, inf

    def __call__(self) -> float:
        """Return the time [s]."""
        return self._shown + max(time.monotonic() - self._since, 0.0)

    def run(self) -> None:
        """Go on as the machine's clock does."""
        self._shown, self._since = self(), time.monotonic()

    def stand(self) -> None:
        """Stand still."""
        self._shown, self._since = self(), inf

    def skip(self, seconds: float) -> None:
        """Be put forward [s]."""
        self._shown += seconds


def with_rates(trajectory: Trajectory) -> Trajectory:
    """Return a motion that states velocities: one that states none goes through its points smoothly.

    At each point it is as fast as on the parabola through it and its neighbours, at both ends it is at rest.
    """
    if trajectory.interpolation is not Interpolation.LINEAR:
        return trajectory
    velocities = np.gradient(trajectory.positions, trajectory.times, axis=0)
    velocities[[0, -1]] = 0.0
    return Trajectory(trajectory.joint_names, trajectory.times, trajectory.positions, velocities)


def from_place(trajectory: Trajectory, here: Floats, limits: JointLimits) -> Trajectory:
    """Return a motion that begins where a robot is told to be, slowly on to where it begins itself.

    Args:
        trajectory: It states velocities.
        here: Where its joints are told to be, shape (n,) [rad | m].
        limits: Of its joints.
    """
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
    """Return limits that a motion keeps: where it breaks one, it is braked no harder than it moves itself."""
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
