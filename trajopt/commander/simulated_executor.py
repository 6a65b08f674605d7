"""A robot in MuJoCo: follows trajectories under physics, brakes along the path when it is stopped."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.reduced import ReducedModel
from trajopt.model.trajectory import Interpolation, Trajectory
from trajopt.simulate import Rollout, simulate

BRAKING = 0.4
"""Time in which a stopped motion comes to rest [s]."""
POINTS = 41
"""Points of the braking."""


@dataclass(frozen=True, eq=False)
class _Motion:
    """A motion under way: all of it is simulated when it begins, and time uncovers it.

    Attributes:
        rollout: What the robot does if nobody stops it.
        begun: When it began, on the clock [s].
    """

    rollout: Rollout
    begun: float

    @property
    def end(self) -> Floats:
        """Positions of all joints at rest after it."""
        return self.rollout.reduced.all_positions(self.rollout.positions[-1])

    def positions(self, elapsed: float) -> Floats:
        """Return positions of all joints so many seconds after it began."""
        rollout = self.rollout
        joints = range(len(rollout.joint_names))
        group = [float(np.interp(elapsed, rollout.times, rollout.positions[:, joint])) for joint in joints]
        return rollout.reduced.all_positions(np.array(group))


class SimulatedExecutor:
    """Moves a robot in MuJoCo.

    Waiting for a motion costs the time of computing it only. One that is not waited for goes on in real
    time; physics being the same every time, a stop simulates what was done until then, and the braking.
    """

    def __init__(self, positions: Floats, *, clock: Callable[[], float] = time.monotonic) -> None:
        """Put the robot somewhere.

        Args:
            positions: Of all joints, shape (number of joints,) [rad | m].
            clock: Tells the time that motions not waited for go by [s].
        """
        self._at = positions
        self._clock = clock
        self._motion: _Motion | None = None

    def positions(self) -> Floats:
        """Return where all joints are now [rad | m]."""
        motion = self._motion
        return self._at if motion is None else motion.positions(self._clock() - motion.begun)

    def start(self, reduced: ReducedModel, trajectory: Trajectory) -> None:
        """Begin to follow a trajectory; it is simulated here and now, and time uncovers it.

        Raises:
            ModelError: If the robot has no masses, or the trajectory is of other joints.
        """
        self._motion = _Motion(simulate(reduced, trajectory), self._clock())

    def moving(self) -> bool:
        """Say whether a motion is under way."""
        motion = self._motion
        return motion is not None and self._clock() - motion.begun < motion.rollout.duration

    def wait(self) -> str:
        """Let the motion end, without the time that it takes; say what it touched, and what gave way."""
        motion = self._motion
        if motion is None:
            return ""
        self._rest(motion)
        return _remarks(motion.rollout)

    def stop(self) -> None:
        """Brake along the path, so that the robot stays on what was proven."""
        motion = self._motion
        if motion is None:
            return
        elapsed = self._clock() - motion.begun
        planned = motion.rollout.trajectory
        if elapsed < planned.duration:
            motion = _Motion(simulate(motion.rollout.reduced, braked(planned, elapsed)), motion.begun)
        self._rest(motion)

    def _rest(self, motion: _Motion) -> None:
        self._at, self._motion = motion.end, None


def braked(trajectory: Trajectory, moment: float) -> Trajectory:
    """Return the motion until a moment, and from there to rest along the same path.

    After the moment t the rate of the motion falls as (1 + cos(pi u / b)) / 2 over the time b of braking, so
    that at the time u it is where the original is at t + u / 2 + b sin(pi u / b) / (2 pi). Accelerations are
    continuous.

    Args:
        trajectory: The motion.
        moment: When it is stopped [s].
    """
    points = trajectory.times
    if trajectory.interpolation is not Interpolation.QUINTIC:
        # The new motion is quintic: many points keep it near what is not.
        step = BRAKING / POINTS
        points = step * np.arange(trajectory.duration // step, dtype=np.float64)
    before: Floats = points[points < moment]
    after = BRAKING / (POINTS - 1) * np.arange(POINTS, dtype=np.float64)
    phase = np.pi * after / BRAKING
    still = np.zeros(len(before))
    rate = np.concatenate((still + 1.0, (1.0 + np.cos(phase)) / 2.0))[:, None]
    change = np.concatenate((still, -np.pi / (2.0 * BRAKING) * np.sin(phase)))[:, None]
    source = np.concatenate((before, moment + after / 2.0 + BRAKING * np.sin(phase) / (2.0 * np.pi)))
    within = (source <= trajectory.duration)[:, None]
    velocity, acceleration = within * trajectory(source, 1), within * trajectory(source, 2)
    return Trajectory(
        trajectory.joint_names,
        np.concatenate((before, moment + after)),
        trajectory(source),
        velocity * rate,
        acceleration * rate**2 + velocity * change,
    )


def _remarks(rollout: Rollout) -> str:
    if rollout.diverged is not None:
        return rollout.summary()
    remarks = [str(contact) for contact in rollout.collisions]
    remarks += [f"the motor of {joint} was at its limit" for joint in rollout.saturated]
    return "; ".join(remarks)
