"""A trajectory among what changes with time: the robot's joints beside those that time drives."""

from dataclasses import replace

import numpy as np

from trajopt.arrays import Floats, readonly
from trajopt.model.piecewise import refined
from trajopt.model.timed import TimedModel
from trajopt.model.trajectory import Trajectory
from trajopt.verify.kernel.kinematics import Kinematics, Poses
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.kernel.options import VerifyOptions
from trajopt.verify.kernel.polynomials import Polynomials


class TimedMotion(Motion):
    """A motion of a timed model, by the clock of its scene, which shows 0 at the start.

    Attributes:
        timed: The model.
    """

    def __init__(
        self, timed: TimedModel, trajectory: Trajectory, *, kinematics: Kinematics, options: VerifyOptions
    ) -> None:
        """Join the polynomials of the robot's joints and of those that time drives.

        Args:
            timed: The model.
            trajectory: Of the group's joints.
            kinematics: Of the timed model.
            options: Numbers to judge with.
        """
        self.timed = timed
        robot = Polynomials(trajectory.times, trajectory.coefficients)
        driven = Polynomials(timed.driven.times, timed.driven.coefficients)
        self._take(timed.reduced, trajectory, beside(robot, driven), kinematics, options)

    @property
    def differentiable(self) -> bool:
        """Whether the velocity has no jumps: that of a track may jump at its times."""
        return False

    def poses(self, times: Floats) -> Poses:
        """Compute where all joint frames are at times of shape (c,)."""
        positions = self.timed.positions(self.trajectory(times), times)
        return replace(self.kinematics.poses(positions), times=times)


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
