"""A trajectory moving a robot: positions of its joints and bounds on how they change."""

from functools import cached_property

import numpy as np

from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats
from trajopt.values.errors import ProblemError, shown
from trajopt.values.trajectory import Interpolation, Trajectory
from trajopt.verify.kernel.kinematics import Kinematics, Poses
from trajopt.verify.kernel.options import VerifyOptions
from trajopt.verify.kernel.polynomials import Polynomials


class Motion:
    """A trajectory of a reduced model, as every check sees it.

    Attributes:
        reduced: The model.
        trajectory: The trajectory.
        kinematics: Forward kinematics of the model.
        options: Numbers to judge with.
        position: Of the group's joints.
        staying: How long it rests where it ends, before it counts as over [s].
        rests_after: Whether it is followed by rest; else by a motion that goes on from it.
        clock: What the scene's clock shows when it begins [s].
        among: The same motion together with what changes with time; itself if nothing does.
    """

    def __init__(
        self,
        reduced: ReducedModel,
        trajectory: Trajectory,
        *,
        kinematics: Kinematics,
        options: VerifyOptions,
        rests_after: bool = True,
    ) -> None:
        """Differentiate the polynomials.

        Raises:
            ProblemError: If the trajectory is not one of the group's joints.
        """
        if trajectory.joint_names != reduced.joint_names:
            raise ProblemError(
                f"the trajectory moves {', '.join(trajectory.joint_names)}, but group "
                f"{shown(reduced.group)} has the joints {', '.join(reduced.joint_names)}"
            )
        positions = Polynomials(trajectory.times, trajectory.coefficients)
        self._take(reduced, trajectory, positions, kinematics, options)
        self.rests_after = rests_after

    def _take(
        self,
        reduced: ReducedModel,
        trajectory: Trajectory,
        position: Polynomials,
        kinematics: Kinematics,
        options: VerifyOptions,
    ) -> None:
        self.reduced = reduced
        self.trajectory = trajectory
        self.kinematics = kinematics
        self.options = options
        self.staying, self.rests_after, self.clock = 0.0, True, 0.0
        self.position = position
        self.among: Motion = self

    @cached_property
    def group(self) -> tuple[Polynomials, Polynomials, Polynomials, Polynomials]:
        """Position of the group's joints and its derivatives, by order 0 to 3."""
        velocity = self.position.derivative()
        acceleration = velocity.derivative()
        return (self.position, velocity, acceleration, acceleration.derivative())

    @cached_property
    def _spread(self) -> Floats:
        spread: Floats = np.zeros((len(self.kinematics.parents), len(self.reduced.joint_names)))
        spread[1:] = np.abs(self.reduced.mimic_matrix)
        return spread

    def between(self, begin: float, end: float) -> "Motion":
        """Return the part from one time to another [s], its own time starting at 0."""
        part = self.trajectory.between(begin, end)
        motion = Motion(self.reduced, part, kinematics=self.kinematics, options=self.options)
        if self.among is not self:
            motion.among = self.among.between(begin, end)
        return motion

    def moving(self, order: int) -> Polynomials:
        """Return positions or a derivative of all joints that move, mimic joints too, in model order."""
        matrix, offset = self.reduced.mimic_matrix, self.reduced.mimic_offset
        if len(matrix) == len(self.reduced.joint_names):
            return self.group[order] if order else self.position
        return self.group[order].combined(matrix, offset if order == 0 else np.zeros_like(offset))

    @cached_property
    def acceleration_jumps(self) -> Floats:
        """By how much the group's accelerations jump at each of the trajectory's times, from rest on.

        Of shape (k, n) [rad/s^2 | m/s^2].
        """
        coefficients, lengths = self.group[2].coefficients, np.diff(self.trajectory.times)
        reached = np.zeros(coefficients.shape[1:])
        for coefficient in coefficients:
            reached = reached * lengths[:, None] + coefficient
        rest = np.zeros((1, coefficients.shape[2]))
        after = rest if self.rests_after else reached[-1:]
        return np.concatenate((coefficients[-1], after)) - np.concatenate((rest, reached))

    @property
    def duration(self) -> float:
        """Length of the trajectory [s]."""
        return self.trajectory.duration

    @property
    def differentiable(self) -> bool:
        """Whether the velocity has no jumps."""
        return self.trajectory.interpolation is not Interpolation.LINEAR

    def positions(self, times: Floats) -> Floats:
        """Return the positions of all joints that it moves at times (c,), shape (c, n) [rad | m]."""
        return self.trajectory(times)

    def poses(self, times: Floats) -> Poses:
        """Compute where all joint frames are at times of shape (c,)."""
        if len(times) == 1 and times[0] == self.duration:
            return self._poses_at_end
        return self.kinematics.poses(self.positions(times))

    @cached_property
    def _poses_at_end(self) -> Poses:
        """Where all joint frames are at the end, which every goal asks."""
        return self.kinematics.poses(self.positions(np.array((self.duration,))))

    def deviation(self, begin: Floats, end: Floats) -> Floats:
        """Bound how far joints get from where they are in the middle of intervals.

        Args:
            begin: Start of each interval, shape (c,) [s].
            end: End of each, shape (c,) [s].

        Returns:
            Shape (c, joints of the model) [rad | m]; column 0 (the world) is zero.
        """
        low, high = self.group[0].range(begin, end)
        middle = self.positions((begin + end) / 2)
        return np.maximum(high - middle, middle - low) @ self._spread.T

    def rates(self, begin: Floats, end: Floats, order: int) -> Floats:
        """Bound the size of a derivative of the joints' positions over intervals.

        Args:
            begin: Start of each interval, shape (c,) [s].
            end: End of each, shape (c,) [s].
            order: 1 for velocity, 2 for acceleration.

        Returns:
            Shape (c, joints of the model); column 0 (the world) is zero.
        """
        low, high = self.group[order].range(begin, end)
        return np.maximum(high, -low) @ self._spread.T
