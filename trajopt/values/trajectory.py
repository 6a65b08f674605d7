"""Path q(s), without time, and Trajectory q(t), timed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from functools import cache, cached_property

import numpy as np
from numpy.typing import ArrayLike

from trajopt.values.arrays import (
    Floats,
    Value,
    floats,
    floats_of_any_shape,
    number,
    one_of,
    readonly,
    sequence,
)
from trajopt.values.errors import JointNotFound, ShapeError, listed
from trajopt.values.errors.arguments import checked
from trajopt.values.printed import in_number

MEETING = 1e-5
"""Largest difference of two motions at their junction [rad | m, by second, by second squared]: the judge
allows a tenth of it for the start state.
"""


@checked
@dataclass(frozen=True, eq=False)
class Path(Value):
    """A polyline through knots in joint space, shape (N, n) [rad | m], N >= 2, without time."""

    joint_names: tuple[str, ...]
    knots: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "joint_names", sequence("joint_names", self.joint_names))
        object.__setattr__(self, "knots", floats("knots", self.knots, (None, len(self.joint_names))))
        if len(self.knots) < 2:
            raise ShapeError("knots", "a path needs at least two")

    def __repr__(self) -> str:
        return f"Path({in_number(self.knots, 'knot')}, {in_number(self.joint_names, 'joint')})"

    @property
    def length(self) -> float:
        """Sum of the Euclidean lengths of the segments in joint space [rad | m]."""
        return float(np.linalg.norm(np.diff(self.knots, axis=0), axis=1).sum())


_INSTANT = 1e-9
"""Times closer than this are equal [s]."""


_LARGEST = 1e100
"""Larger coefficients would overflow in derivatives and products."""
LONGEST = 1e9
"""Longest duration of a trajectory: thirty years [s]."""
_MOST_SAMPLES = 1_000_000
"""More samples are a mistake in the rate: a quarter of an hour at 1 kHz."""
_LEAST_STEP = 0.01
"""Smallest last step, as a share of a step: over a shorter one, rounding of positions appears as
acceleration.
"""


class Interpolation(Enum):
    """Interpolation between the points of a trajectory."""

    LINEAR = 1
    CUBIC = 3
    QUINTIC = 5


@checked
@dataclass(frozen=True, eq=False)
class Trajectory(Value):
    """Joint positions over time: polynomials between points.

    With accelerations the polynomials are quintic, with velocities cubic, with neither linear
    (as `trajectory_msgs/JointTrajectory` is executed).

    Attributes:
        times: Time of each point from the start, increasing from 0, shape (k,) [s].
        positions: Shape (k, n) [rad | m].
        velocities: Shape (k, n) [rad/s | m/s], or None.
        accelerations: Shape (k, n) [rad/s^2 | m/s^2], or None; needs velocities.
    """

    joint_names: tuple[str, ...]
    times: Floats
    positions: Floats
    velocities: Floats | None = None
    accelerations: Floats | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "times", floats("times", self.times, (None,)))
        object.__setattr__(self, "joint_names", sequence("joint_names", self.joint_names))
        count, joints = len(self.times), len(self.joint_names)
        for name in ("positions", "velocities", "accelerations"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, floats(name, value, (count, joints)))
        if count < 2 or (self.times[1:] <= self.times[:-1]).any() or self.times[0] != 0.0:
            raise ShapeError("times", "need at least two points, starting at 0 and increasing")
        if self.times[-1] > LONGEST:
            raise ShapeError("times", f"end at {self.times[-1]:g} s; {LONGEST:g} s are the most")
        if len(set(self.joint_names)) != joints:
            raise ShapeError("joint_names", f"name a joint twice: {listed(self.joint_names)}")
        if self.accelerations is not None and self.velocities is None:
            raise ShapeError("velocities", "are missing while accelerations are given")

    @checked
    def ordered(self, joint_names: tuple[str, ...]) -> Trajectory:
        """Return the motion with its joints in another order; itself if the order is the same.

        Raises:
            JointNotFound: If a joint is missing.
            ShapeError: If it has joints not named.
        """
        if joint_names == self.joint_names:
            return self
        for name in joint_names:
            if name not in self.joint_names:
                raise JointNotFound("joint in the trajectory", name, self.joint_names)
        extra = sorted(set(self.joint_names) - set(joint_names))
        if extra:
            raise ShapeError("trajectory", f"moves joints outside the group: {', '.join(extra)}")
        order = [self.joint_names.index(name) for name in joint_names]
        velocities, accelerations = self.velocities, self.accelerations
        return Trajectory(
            joint_names,
            self.times,
            self.positions[:, order],
            None if velocities is None else velocities[:, order],
            None if accelerations is None else accelerations[:, order],
        )

    @checked
    def between(self, begin: float, end: float) -> Trajectory:
        """Return the part of the motion between two times, with its own time starting at 0.

        Args:
            begin: Start time, at least 0 [s].
            end: End time, later, at most the duration [s].

        Raises:
            ShapeError: If the times are not in order or not within the motion.
        """
        if not 0.0 <= begin < end <= self.duration:
            raise ShapeError("part", f"from {begin:g} to {end:g} s is none of 0 to {self.duration:g} s")
        inner = (self.times > begin + _INSTANT) & (self.times < end - _INSTANT)
        times = np.concatenate(((begin,), self.times[inner], (end,)))
        # A polynomial's restriction has its own values at its ends, and what its points state between.
        given = [rows for rows in (self.positions, self.velocities, self.accelerations) if rows is not None]
        ends = np.array((begin, end))
        segment = np.clip(np.searchsorted(self.times, ends, side="right") - 1, 0, len(self.times) - 2)
        since, coefficients = (ends - self.times[segment])[:, None], self.coefficients[:, segment]
        values: list[Floats] = []
        for rows in given:
            at = coefficients[0]
            for coefficient in coefficients[1:]:
                at = at * since + coefficient
            values.append(np.concatenate((at[:1], rows[inner], at[1:])))
            coefficients = coefficients[:-1] * np.arange(len(coefficients) - 1, 0, -1)[:, None, None]
        return Trajectory(self.joint_names, times - begin, *values)

    def followed_by(self, other: Trajectory) -> Trajectory:
        """Return this motion followed by another.

        Args:
            other: Of the same joints in the same order, and with the same velocity and acceleration at the
                junction.

        Raises:
            ShapeError: If the motions do not meet.
            ProblemError: If `other` is not a trajectory.
        """
        one_of("other", other, Trajectory)
        if other.joint_names != self.joint_names or other.interpolation is not self.interpolation:
            raise ShapeError("other", "must move the same joints, and state the same derivatives")
        rows: list[Floats] = []
        for name in ("positions", "velocities", "accelerations"):
            mine, its = getattr(self, name), getattr(other, name)
            if mine is None:
                continue
            off = float(np.abs(its[0] - mine[-1]).max())
            if off > MEETING:
                raise ShapeError(
                    "other", f"its first {name} are off by {off:.3g} from the last of this motion"
                )
            rows.append(np.concatenate((mine, its[1:])))
        times = np.concatenate((self.times, self.duration + other.times[1:]))
        return Trajectory(self.joint_names, times, *rows)

    def sampled(self, hz: float) -> Trajectory:
        """Return the motion at a fixed rate, for a controller.

        The times are 0, 1/hz, 2/hz, ... and the duration, so the last step may be shorter than the others, or
        longer by a hundredth; positions, velocities and accelerations have shape (k, n). At these times the
        values are exact; between them the result approximates the motion, so judge it again.

        Raises:
            ShapeError: If the rate is not positive, or leads to more than a million samples.
        """
        rate = number("hz", hz)
        if rate <= 0.0 or self.duration * rate > _MOST_SAMPLES:
            raise ShapeError(
                "hz",
                f"must be positive and give at most {_MOST_SAMPLES} samples; {rate:g} Hz over "
                f"{self.duration:g} s do not",
            )
        steps = max(1, math.ceil(self.duration * rate - _LEAST_STEP))
        times = np.append(np.arange(steps) / rate, self.duration)
        rows = [self(times, order) for order in range(3)]
        for row, given in zip(rows, (self.positions, self.velocities, self.accelerations), strict=True):
            if given is not None:
                row[-1] = given[-1]  # evaluated, it may differ in the last bit
        return Trajectory(self.joint_names, times, *rows)

    def as_dict(self) -> dict[str, object]:
        """Return `joint_names` and `points` as plain data, for `trajopt.files.moveit.read_trajectory`."""
        columns = (
            ("positions", self.positions),
            ("velocities", self.velocities),
            ("accelerations", self.accelerations),
        )
        given = {key: rows.tolist() for key, rows in columns if rows is not None}
        names = ("time_from_start", *given)
        rows = zip(self.times.tolist(), *given.values(), strict=True)
        points = [dict(zip(names, at, strict=True)) for at in rows]
        return {"joint_names": list(self.joint_names), "points": points}

    @property
    def interpolation(self) -> Interpolation:
        """Interpolation between the points."""
        if self.accelerations is not None:
            return Interpolation.QUINTIC
        return Interpolation.LINEAR if self.velocities is None else Interpolation.CUBIC

    @property
    def duration(self) -> float:
        return float(self.times[-1])

    @cached_property
    def coefficients(self) -> Floats:
        """Polynomial coefficients, shape (degree + 1, k - 1, n), highest power first.

        In the time since the start of each segment, as in `scipy.interpolate.PPoly`.

        Raises:
            ShapeError: If the numbers are too large, or two times too close, so that they overflow.
        """
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            found = _hermite(self)
        usable = np.abs(found) <= _LARGEST
        if not usable.all():
            _, segment, joint = np.argwhere(~usable)[0].tolist()
            begin, end = self.times[segment : segment + 2]
            raise ShapeError(
                "points",
                f"of {self.joint_names[joint]} are not a motion from {begin:g} to {end:g} s: the polynomial "
                "between them overflows; their numbers are too large, or their times too near to each other",
            )
        return readonly(found)

    @cached_property
    def _derivatives(self) -> tuple[Floats, ...]:
        found = [self.coefficients]
        for _ in range(3):
            last = found[-1]
            powers = np.arange(len(last) - 1, 0, -1)[:, None, None]
            found.append(last[:-1] * powers if len(last) > 1 else np.zeros_like(last))
        return tuple(found)

    def __call__(self, t: ArrayLike, order: int = 0) -> Floats:
        """Evaluate at times, which are clipped to the duration.

        Args:
            t: Times [s], any shape.
            order: 0 position, 1 velocity, 2 acceleration, 3 jerk.

        Returns:
            Shape t.shape + (n,).

        Raises:
            ShapeError: If a time is not a number, or the order is not 0 to 3.
        """
        if order not in (0, 1, 2, 3):
            raise ShapeError("order", f"must be 0 to 3, is {order}")
        moments = np.minimum(np.maximum(floats_of_any_shape("t", t), 0.0), self.duration)
        segment = np.minimum(self.times.searchsorted(moments, side="right") - 1, len(self.times) - 2)
        since = (moments - self.times[segment])[..., None]
        first, *others = self._derivatives[order] if order else self.coefficients
        value = first[segment]
        for coefficient in others:
            value = value * since + coefficient[segment]
        return value

    def __repr__(self) -> str:
        return (
            f"Trajectory({in_number(self.times, 'point')}, {in_number(self.joint_names, 'joint')}, "
            f"{self.duration:.3f} s, {self.interpolation.name.lower()})"
        )


def _hermite(trajectory: Trajectory) -> Floats:
    h = (trajectory.times[1:] - trajectory.times[:-1])[:, None]
    p0, p1 = trajectory.positions[:-1], trajectory.positions[1:]
    if trajectory.velocities is None:
        return np.stack(((p1 - p0) / h, p0))
    v0, v1 = trajectory.velocities[:-1], trajectory.velocities[1:]
    if trajectory.accelerations is None:
        d = (p1 - p0) / h
        return np.stack(((v0 + v1 - 2 * d) / h**2, (3 * d - 2 * v0 - v1) / h, v0, p0))
    a0, a1 = trajectory.accelerations[:-1], trajectory.accelerations[1:]
    # Residuals of position, velocity, acceleration at the end after the quadratic from the start.
    square = h**2
    dp = p1 - p0 - v0 * h - a0 * square / 2
    dv = (v1 - v0 - a0 * h) * h
    da = (a1 - a0) * square
    found = np.empty((6, *p0.shape))
    found[0] = (6 * dp - 3 * dv + da / 2) / h**5
    found[1] = (-15 * dp + 7 * dv - da) / h**4
    found[2] = (10 * dp - 4 * dv + da / 2) / h**3
    found[3], found[4], found[5] = a0 / 2, v0, p0
    return found


def refined(times: Floats, knots: Floats, coefficients: Floats, degree: int) -> Floats:
    """Return piecewise polynomials on finer pieces, by Taylor's formula, shape (degree, k, n).

    They are constant outside their own times.

    Args:
        times: Ends of the k finer pieces, which include all inner ends of the coarse ones, shape (k + 1,)
            [s].
        coefficients: In the time since the start of each piece, highest power first, shape (d + 1, j, n).
        degree: Number of powers of the result, d + 1 or more.
    """
    begins = times[:-1]
    piece = np.clip(np.searchsorted(knots, begins, side="right") - 1, 0, len(knots) - 2)
    since = (np.clip(begins, knots[0], knots[-1]) - knots[piece])[:, None]
    taylor = coefficients[:, piece].copy()
    for done in range(len(taylor) - 1):
        for power in range(1, len(taylor) - done):
            taylor[power] += since * taylor[power - 1]
    taylor[:-1, (begins < knots[0]) | (begins >= knots[-1])] = 0.0
    return np.pad(taylor, ((degree - len(taylor), 0), (0, 0), (0, 0)))


def state_of(trajectory: Trajectory, t: float) -> Floats:
    """Return positions, velocities and accelerations at a time [s], clipped to the duration, shape (3, n).

    At the ends exactly the stated values, if any.
    """
    times, duration = trajectory.times, trajectory.duration
    velocities, accelerations = trajectory.velocities, trajectory.accelerations
    if velocities is not None and accelerations is not None and not 0.0 < t < duration:
        end = 0 if t <= 0.0 else -1
        return np.array((trajectory.positions[end], velocities[end], accelerations[end]))
    moment = min(max(t, 0.0), duration)
    segment = min(max(int(times.searchsorted(moment, side="right")) - 1, 0), len(times) - 2)
    since, rows = moment - float(times[segment]), trajectory.coefficients[:, segment]
    factors, powers = _taylor(len(rows))
    return (factors * since**powers) @ rows


@cache
def _taylor(count: int) -> tuple[Floats, Floats]:
    """Return factors and powers of the time in value, slope and second derivative, (3, count) each."""
    powers = np.arange(count, dtype=np.float64)[::-1]
    factors: Floats = np.array((np.ones(count), powers, powers * (powers - 1.0)))
    return readonly(factors), readonly(np.maximum(powers - np.arange(3.0)[:, None], 0.0))
