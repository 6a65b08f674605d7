"""A trajectory among what changes with time: the robot's joints beside those that time drives."""

from dataclasses import replace

import numpy as np

from trajopt.scene.timed import TimedModel
from trajopt.values.arrays import Floats, readonly
from trajopt.values.trajectory import Trajectory, refined
from trajopt.verify.kernel.kinematics import Kinematics, Poses
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.kernel.options import VerifyOptions
from trajopt.verify.kernel.polynomials import Polynomials


class TimedMotion(Motion):
    """A motion of a timed model.

    Attributes:
        timed: The model.
    """

    def __init__(
        self,
        timed: TimedModel,
        trajectory: Trajectory,
        *,
        kinematics: Kinematics,
        options: VerifyOptions,
        staying: float = 0.0,
        clock: float = 0.0,
    ) -> None:
        """Join the polynomials of the robot's joints and of those that time drives.

        Args:
            timed: The model.
            trajectory: Of the group's joints.
            kinematics: Of the timed model.
            options: Numbers to judge with.
            staying: How long the robot rests where the trajectory ends [s].
            clock: What the scene's clock shows when it begins [s].
        """
        self.timed = timed
        robot = _stayed(trajectory, staying)
        driven = Polynomials(timed.driven.times - clock, timed.driven.coefficients)
        self._take(timed.reduced, trajectory, beside(robot, driven), kinematics, options)
        self.staying, self.clock = staying, clock

    @property
    def duration(self) -> float:
        """Length of the trajectory, and of the rest after it [s]."""
        return self.trajectory.duration + self.staying

    @property
    def differentiable(self) -> bool:
        """Whether the velocity has no jumps: that of a track may jump at its times."""
        return False

    def between(self, begin: float, end: float) -> "TimedMotion":
        """Return the part from one time to another [s], its own time starting at 0."""
        return TimedMotion(
            self.timed,
            self.trajectory.between(begin, end),
            kinematics=self.kinematics,
            options=self.options,
            clock=self.clock + begin,
        )

    def positions(self, times: Floats) -> Floats:
        """Return the positions of the robot's joints, and of those that time drives, at times (c,)."""
        return self.timed.positions(self.trajectory(times), times + self.clock)

    def poses(self, times: Floats) -> Poses:
        """Compute where all joint frames are at times of shape (c,)."""
        return replace(self.kinematics.poses(self.positions(times)), times=times + self.clock)


def _stayed(trajectory: Trajectory, staying: float) -> Polynomials:
    """Return a trajectory, with a rest where it ends."""
    times, coefficients = trajectory.times, trajectory.coefficients
    if staying <= 0.0:
        return Polynomials(times, coefficients)
    rest = np.zeros((len(coefficients), 1, coefficients.shape[2]))
    rest[-1] = trajectory.positions[-1]
    return Polynomials(
        readonly(np.append(times, times[-1] + staying)),
        readonly(np.concatenate((coefficients, rest), axis=1)),
    )


def beside(one: Polynomials, other: Polynomials) -> Polynomials:
    """Return functions of both, over the times of the first.

    The second rest before their first time and after their last.
    """
    begin, end = one.times[0], one.times[-1]
    inside = other.times[(other.times > begin) & (other.times < end)]
    times = np.unique(np.concatenate((one.times, inside)))
    degree = max(len(one.coefficients), len(other.coefficients))
    both = [refined(times, each.times, each.coefficients, degree) for each in (one, other)]
    return Polynomials(readonly(times), readonly(np.concatenate(both, axis=2)))
