"""Motions for checks: polynomials of the joints, alone or among dynamic obstacles."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from trajopt.native import proof
from trajopt.scene.reduced import ReducedModel, TimedModel
from trajopt.values.arrays import Floats, Ints, readonly
from trajopt.values.errors import ProblemError, shown
from trajopt.values.trajectory import Interpolation, Trajectory
from trajopt.verify.kernel.kinematics import Kinematics, Poses
from trajopt.verify.kernel.options import VerifyOptions

TIGHTNESS = 1e-9
"""Accuracy of extremes, relative to the larger of their size and one."""


@dataclass(frozen=True, eq=False)
class Extremes:
    """Largest or smallest values of n functions, with their times [s], shape (n,) each."""

    values: Floats
    times: Floats


@dataclass(frozen=True, eq=False)
class Polynomials:
    """n piecewise polynomial functions of time, with bounds that hold at every time.

    In Bernstein form a polynomial lies between its smallest and its largest control value (Farouki, CAGD
    2012).

    Attributes:
        times: Breakpoints, increasing, shape (k,) [s].
        coefficients: In the time since the start of each piece, highest power first, shape (degree + 1, k -
            1, n).
    """

    times: Floats
    coefficients: Floats

    def derivative(self) -> "Polynomials":
        """Return the derivative in time."""
        degree = len(self.coefficients) - 1
        if degree == 0:
            return Polynomials(self.times, readonly(np.zeros_like(self.coefficients)))
        powers = np.arange(degree, 0, -1.0)[:, None, None]
        return Polynomials(self.times, readonly(self.coefficients[:-1] * powers))

    def combined(self, matrix: Floats, offset: Floats) -> "Polynomials":
        """Return the m functions `matrix @ f + offset`, for a matrix (m, n) and offsets (m,)."""
        coefficients = self.coefficients @ matrix.T
        coefficients[-1] += offset
        return Polynomials(self.times, readonly(coefficients))

    def range(self, begin: Floats, end: Floats) -> tuple[Floats, Floats]:
        """Bound the functions over intervals (c,) [s], from below and above, shape (c, n) each."""
        sides = (np.ascontiguousarray(side) for side in (begin, end))
        return proof.ranges(self.times, np.ascontiguousarray(self.coefficients), *sides)

    def extremes(self) -> tuple[Extremes, Extremes]:
        """Find largest and smallest values of each function by branch and bound, to within `TIGHTNESS`."""
        coefficients = np.ascontiguousarray(self.coefficients)
        high, time_of_high = proof.largest(self.times, coefficients, 1.0, TIGHTNESS)
        low, time_of_low = proof.largest(self.times, coefficients, -1.0, TIGHTNESS)
        return Extremes(high, time_of_high), Extremes(-low, time_of_low)

    def at(self, piece: Ints, since: Floats) -> Floats:
        """Evaluate pieces at times since their starts, both of shape (s,), shape (s, n)."""
        return proof.sampled(np.ascontiguousarray(self.coefficients), piece, since)

    def beside(self, other: "Polynomials") -> "Polynomials":
        """Join these functions and others, which rest outside of their own times, over the times of these."""
        own, its = (np.ascontiguousarray(each.coefficients) for each in (self, other))
        return Polynomials(*map(readonly, proof.beside(self.times, own, other.times, its)))


class JudgedMotion:
    """A trajectory of a reduced model, for checks.

    Attributes:
        staying: Duration of the rest after the trajectory that still counts as motion [s].
        rests_after: Whether rest follows; otherwise another motion follows.
        clock: Scene clock at its start [s].
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
        self._among: JudgedMotion | None = None

    @cached_property
    def group(self) -> tuple[Polynomials, Polynomials, Polynomials, Polynomials]:
        """Positions of the group's joints and their derivatives, by order 0 to 3."""
        velocity = self.position.derivative()
        acceleration = velocity.derivative()
        return (self.position, velocity, acceleration, acceleration.derivative())

    @cached_property
    def _spread(self) -> Floats:
        spread: Floats = np.zeros((len(self.kinematics.parents), len(self.reduced.joint_names)))
        spread[1:] = np.abs(self.reduced.mimic_matrix)
        return spread

    def between(self, begin: float, end: float) -> "JudgedMotion":
        """Return the part between two times [s], with its own time starting at 0."""
        part = self.trajectory.between(begin, end)
        motion = JudgedMotion(self.reduced, part, kinematics=self.kinematics, options=self.options)
        if self._among is not None:
            motion.among = self._among.between(begin, end)
        return motion

    @property
    def among(self) -> "JudgedMotion":
        """The same motion among dynamic obstacles; itself if there are none."""
        return self if self._among is None else self._among

    @among.setter
    def among(self, timed: "JudgedMotion") -> None:
        """Store it; only weakly refer to the motion itself, so that it is freed with its last user."""
        self._among = None if timed is self else timed

    def moving(self, order: int) -> Polynomials:
        """Return positions or a derivative of all movable joints, including mimic joints, in model order."""
        matrix, offset = self.reduced.mimic_matrix, self.reduced.mimic_offset
        if len(matrix) == len(self.reduced.joint_names):
            return self.group[order] if order else self.position
        return self.group[order].combined(matrix, offset if order == 0 else np.zeros_like(offset))

    @cached_property
    def acceleration_jumps(self) -> Floats:
        """Jumps of the group's accelerations at each of the trajectory's times, from rest on.

        Shape (k, n) [rad/s^2 | m/s^2].
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
        return self.trajectory.duration

    @property
    def differentiable(self) -> bool:
        """Whether the velocity is continuous."""
        return self.trajectory.interpolation is not Interpolation.LINEAR

    def positions(self, times: Floats) -> Floats:
        return self.trajectory(times)

    def poses(self, times: Floats) -> Poses:
        """Compute placements of all joint frames at times of shape (c,)."""
        if len(times) == 1 and times[0] == self.duration:
            return self._poses_at_end
        return self.kinematics.poses(self.positions(times))

    @cached_property
    def _poses_at_end(self) -> Poses:
        return self.kinematics.poses(self.positions(np.array((self.duration,))))

    def deviation(self, begin: Floats, end: Floats) -> Floats:
        """Bound the distance of joints from their positions in the middle of intervals, (c,) each [s].

        Returns:
            Shape (c, joints of the model) [rad | m]; column 0 (the world) is zero.
        """
        low, high = self.group[0].range(begin, end)
        middle = self.positions((begin + end) / 2)
        return np.maximum(high - middle, middle - low) @ self._spread.T

    def rates(self, begin: Floats, end: Floats, order: int) -> Floats:
        """Bound the magnitude of a derivative of the joints' positions over intervals, (c,) each [s].

        Args:
            order: 1 for velocity, 2 for acceleration.

        Returns:
            Shape (c, joints of the model); column 0 (the world) is zero.
        """
        low, high = self.group[order].range(begin, end)
        return np.maximum(high, -low) @ self._spread.T


class TimedMotion(JudgedMotion):
    """A motion of a timed model."""

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
        """Join the polynomials of the robot's joints and of the dynamic obstacles' joints."""
        self.timed = timed
        robot = _stayed(trajectory, staying)
        driven = Polynomials(timed.driven.times - clock, timed.driven.coefficients)
        self._take(timed.reduced, trajectory, robot.beside(driven), kinematics, options)
        self.staying, self.clock = staying, clock

    @property
    def duration(self) -> float:
        return self.trajectory.duration + self.staying

    @property
    def differentiable(self) -> bool:
        """Whether the velocity is continuous; track velocities may jump at knots."""
        return False

    def between(self, begin: float, end: float) -> "TimedMotion":
        return TimedMotion(
            self.timed,
            self.trajectory.between(begin, end),
            kinematics=self.kinematics,
            options=self.options,
            clock=self.clock + begin,
        )

    def positions(self, times: Floats) -> Floats:
        """Return positions of the robot's and of the dynamic obstacles' joints at times, (c,) -> (c, n)."""
        return self.timed.positions(self.trajectory(times), times + self.clock)

    def poses(self, times: Floats) -> Poses:
        return replace(self.kinematics.poses(self.positions(times)), times=times + self.clock)


def _stayed(trajectory: Trajectory, staying: float) -> Polynomials:
    times, coefficients = trajectory.times, trajectory.coefficients
    if staying <= 0.0:
        return Polynomials(times, coefficients)
    rest = np.zeros((len(coefficients), 1, coefficients.shape[2]))
    rest[-1] = trajectory.positions[-1]
    return Polynomials(
        readonly(np.append(times, times[-1] + staying)),
        readonly(np.concatenate((coefficients, rest), axis=1)),
    )


MOST_PIECES = 8
"""Most pieces of a cut interval; the fewest are two."""


def pieces_needed(needed: Floats, reserve: Floats) -> Ints:
    """Return the number of pieces for which a bound that falls with the length is below a reserve, (c,)."""
    wanted = np.ceil(1.25 * needed / np.maximum(reserve, 1e-12))
    return np.clip(wanted, 2, MOST_PIECES).astype(np.int64)


def cut(begin: Floats, end: Floats, pieces: Ints) -> tuple[Floats, Floats]:
    """Cut intervals, (c,) each [s], into equal pieces without gaps; 0 pieces omit an interval."""
    parent = np.repeat(np.arange(len(pieces)), pieces)
    step = counting(pieces)
    width = ((end - begin) / np.maximum(pieces, 1))[parent]
    left = begin[parent] + step * width
    right = np.where(step + 1 == pieces[parent], end[parent], begin[parent] + (step + 1) * width)
    return left, right


def counting(pieces: Ints) -> Ints:
    total = int(pieces.sum())
    return np.arange(total, dtype=np.int64) - np.repeat(np.cumsum(pieces) - pieces, pieces)


LEAST_OF_SLOW = 8
"""Fewest samples of a slow piece: a quintic polynomial has six coefficients."""
MOST_MOMENTS = 1_000_000
"""Most samples of a motion, about 0.5 GB and a few seconds; longer motions are rejected."""


def steps_in_pieces(motion: JudgedMotion) -> Ints:
    """Return the number of steps in each piece of a trajectory, shape (k - 1,)."""
    times, options = motion.trajectory.times, motion.options
    lengths = times[1:] - times[:-1]
    steps = np.ceil(lengths / options.sample_step)
    if (steps > LEAST_OF_SLOW).any():
        position = motion.position
        coefficients, matrix = np.ascontiguousarray(position.coefficients), motion.reduced.mimic_matrix
        speed = proof.speeds(position.times, coefficients, matrix)
        steps = np.minimum(steps, np.maximum(LEAST_OF_SLOW, np.ceil(speed * lengths / options.sample_travel)))
    if steps.sum() > MOST_MOMENTS:
        raise ProblemError(
            f"the motion takes {motion.duration:g} s in {len(lengths)} pieces: to judge it would take "
            f"{steps.sum():.3g} samples, and {MOST_MOMENTS} are the most; judge it in parts"
        )
    return steps.astype(np.int64)


def sampled_times(motion: JudgedMotion) -> Floats:
    """Return sample times for checks without a proof, including the motion's own points [s].

    The step is `sample_step`, or `sample_travel` of joint motion if that is longer, which bounds the samples
    of slow motions.
    """
    times, steps = motion.trajectory.times, steps_in_pieces(motion)
    lengths = np.diff(times)
    if (steps == np.ceil(lengths / motion.options.sample_step)).all():
        even = np.linspace(
            0.0, motion.duration, int(np.ceil(motion.duration / motion.options.sample_step)) + 1
        )
        return np.unique(np.concatenate((even, times)))
    piece = np.repeat(np.arange(len(steps)), steps)
    within = times[piece] + lengths[piece] * counting(steps) / steps[piece]
    return np.unique(np.concatenate((within, times)))
