"""Tracks and timing: motion and existence of objects over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil, comb, inf, isfinite, sqrt

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from trajopt.robot.joints import Anchor
from trajopt.scene.planned_robot import MovingRobot, Planned, model_and_trajectory
from trajopt.values.arrays import Floats, Value, floats, number, one_of, readonly, sequence
from trajopt.values.errors import ModelError, ShapeError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import (
    IDENTITY,
    Placement,
    PlacementLike,
    as_placement,
    as_rotation_vector,
    from_rotation_vector,
)
from trajopt.values.printed import in_number
from trajopt.values.trajectory import LONGEST, Trajectory

MOST_DEGREE = 5
"""Largest degree of a piece's translation, as in trajectories."""
JUMP = 1e-6
"""Largest gap between consecutive pieces [m | rad], from rounding in files."""
TOLERANCE = 2e-3
"""Default error of the tracks of another robot [m]: the size of an arm's tracking error at speed."""
STEADY = 1e-12
"""Slower rotations count as none [rad/s]."""


@dataclass(frozen=True, eq=False)
class Track(Value):
    """The placement of a frame over time: at rest before the first time and after the last.

    In each piece the origin moves along polynomials of time and the frame turns about one axis at a constant
    rate.

    Attributes:
        times: Ends of the k pieces, increasing, shape (k + 1,) [s].
        coefficients: Of the origin's position in the world, in the time since the start of each piece,
            highest power first, shape (degree + 1, k, 3) [m].
        rotations: Of the frame at the start of each piece, shape (k, 3, 3).
        axes: Unit rotation axis in each piece, in the frame itself, shape (k, 3).
        rates: Angular velocity, shape (k,) [rad/s].
    """

    times: Floats
    coefficients: Floats
    rotations: Floats
    axes: Floats
    rates: Floats

    def __post_init__(self) -> None:
        times = floats("times of the track", self.times, (None,))
        if len(times) < 2 or (np.diff(times) <= 0.0).any() or np.abs(times).max() > LONGEST:
            raise ShapeError(
                "times of the track", f"must increase, within {LONGEST:g} s, and be two at least"
            )
        pieces = len(times) - 1
        shapes = {"coefficients": (None, pieces, 3), "rotations": (pieces, 3, 3)}
        for name, shape in {**shapes, "axes": (pieces, 3), "rates": (pieces,)}.items():
            object.__setattr__(self, name, floats(f"{name} of the track", getattr(self, name), shape))
        object.__setattr__(self, "times", times)
        if not 1 <= len(self.coefficients) <= MOST_DEGREE + 1:
            raise ShapeError("coefficients of the track", f"are of degree 0 to {MOST_DEGREE}")
        if np.abs(np.linalg.norm(self.axes, axis=1) - 1.0).max() > JUMP:
            raise ShapeError("axes of the track", "must be of length one")
        self._check_jumps()

    def _check_jumps(self) -> None:
        for piece, (moment, length) in enumerate(zip(self.times[1:-1], np.diff(self.times), strict=False)):
            reached, begins = self._within(piece, float(length)), self._within(piece + 1, 0.0)
            away = float(np.linalg.norm(reached.translation - begins.translation))
            turned = float(np.linalg.norm(as_rotation_vector(reached.rotation.T @ begins.rotation)))
            if away > JUMP or turned > JUMP:
                raise ShapeError(
                    "track",
                    f"jumps at {moment:g} s by {1e3 * away:.3g} mm and {np.rad2deg(turned):.3g} deg",
                )

    @staticmethod
    @checked
    def through(times: ArrayLike, placements: Sequence[PlacementLike]) -> Track:
        """Make a track through placements, straight and at constant angular velocity between them.

        Args:
            times: Increasing, shape (k,) [s].
            placements: Of the frame in the world, k of them.

        Raises:
            ShapeError: If there is not one placement for each of at least two increasing times.
        """
        moments = floats("times of the track", times, (None,))
        places = [
            as_placement(f"placement {index} of the track", item)
            for index, item in enumerate(sequence("placements", placements))
        ]
        if len(places) != len(moments):
            raise ShapeError("track", f"has {len(moments)} times and {len(places)} placements")
        if len(moments) < 2 or (np.diff(moments) <= 0.0).any():
            raise ShapeError("times of the track", f"must be two at least, and increase: {moments.tolist()}")
        length = np.diff(moments)
        points = np.array([where.translation for where in places])
        rotations = np.array([where.rotation for where in places])
        turns = np.array([as_rotation_vector(one.T @ other) for one, other in pairwise(rotations)])
        angle = np.linalg.norm(turns, axis=1)
        return Track(
            moments,
            np.stack((np.diff(points, axis=0) / length[:, None], points[:-1])),
            rotations[:-1],
            _unit(turns, angle),
            angle / length,
        )

    @staticmethod
    @checked
    def constant_velocity(
        placement: PlacementLike,
        velocity: ArrayLike,
        *,
        angular_velocity: ArrayLike = (0.0, 0.0, 0.0),
        start: float = 0.0,
        end: float = LONGEST,
    ) -> Track:
        """Make a track of constant velocity, at rest before `start` and after `end`.

        Args:
            placement: Of the frame at `start`, in the world.
            velocity: Of its origin in the world, shape (3,) [m/s].
            angular_velocity: Of the frame in the world, shape (3,) [rad/s].
            start: When it begins to move [s].
            end: When it stops [s].

        Raises:
            ShapeError: If a number is not finite, or it stops before it begins.
        """
        where = as_placement("placement", placement)
        linear, angular = (
            floats("velocity", velocity, (3,)),
            floats("angular_velocity", angular_velocity, (3,)),
        )
        rate = np.array((float(np.linalg.norm(angular)),))
        return Track(
            np.array((number("start", start), number("end", end))),
            np.stack((linear, where.translation))[:, None],
            where.rotation[None],
            _unit((where.rotation.T @ angular)[None], rate),
            rate,
        )

    @staticmethod
    def of(
        motion: Planned[MovingRobot] | MovingRobot,
        frame: str,
        *,
        reach: float,
        trajectory: Trajectory | None = None,
        base: PlacementLike = IDENTITY,
        start: float = 0.0,
        until: float = inf,
        tolerance: float = TOLERANCE,
    ) -> Prediction:
        """Make the track of a frame of another robot that moves as planned, with its error: a `Prediction`.

        The error is a proven bound on the distance of any point within `reach` of the frame's origin from its
        place on the track. `Scene.with_robot_in_motion` adds a whole robot, and describes the other
        arguments.

        Args:
            motion: A plan, a result with one, or a reduced model.
            frame: Link or tool frame of that robot, or an object that it carries.
            reach: Largest distance of points that move with the frame from its origin [m].

        Raises:
            PlanningFailed: If the result has no plan.
            ProblemError: If `motion` is neither, or the trajectory is missing.
            FrameNotFound: If the frame is unknown.
            ShapeError: If a number is invalid.
        """
        robot, moved = model_and_trajectory("Track.of", motion, trajectory, MovingRobot)
        if number("reach", reach) < 0.0 or number("tolerance", tolerance) <= 0.0:
            name, size = ("reach", reach) if reach < 0.0 else ("tolerance", tolerance)
            raise ShapeError(name, f"must be positive, is {size:g} m")
        where, begin = as_placement("base", base), number("start", start)
        anchor = Anchor(*robot.attachment(one_of("frame", frame, str)))
        if anchor.joint == 0:
            here = where * anchor.placement
            return Prediction(Track.through((begin, begin + moved.duration), (here, here)), until=until)
        found = frame_pieces(robot, moved, anchor, reach=reach, tolerance=tolerance)
        placed = found.coefficients @ where.rotation.T
        placed[-1] += where.translation
        turned = where.rotation @ found.rotations
        track = Track(found.times + begin, placed, turned, found.axes, found.rates)
        return Prediction(track, (found.error, 0.0, 0.0), until)

    @property
    def degree(self) -> int:
        """Highest power of the polynomials."""
        return len(self.coefficients) - 1

    @property
    def end(self) -> float:
        """Time after which the frame rests [s]."""
        return float(self.times[-1])

    def at(self, time: float) -> Placement:
        """Return the placement of the frame in the world at a time [s]."""
        moment = min(max(number("time", time), float(self.times[0])), self.end)
        piece = min(max(int(np.searchsorted(self.times, moment, side="right")) - 1, 0), len(self.rates) - 1)
        return self._within(piece, moment - float(self.times[piece]))

    @checked
    def shifted(self, time: float) -> Track:
        """Return the track with the clock advanced by `time` [s]."""
        return replace(self, times=readonly(self.times - number("time", time)))

    def _within(self, piece: int, since: float) -> Placement:
        point = self.coefficients[0, piece]
        for coefficient in self.coefficients[1:, piece]:
            point = point * since + coefficient
        turned = self.rotations[piece] @ from_rotation_vector(
            self.axes[piece] * float(self.rates[piece]) * since
        )
        return Placement(readonly(turned), readonly(np.array(point)))

    def __repr__(self) -> str:
        return f"Track({self.times[0]:g} to {self.end:g} s, {in_number(self.rates, 'piece')})"


@dataclass(frozen=True, eq=False)
class Prediction(Value):
    """A track with a bounded error, known for a time.

    Attributes:
        error: Radius r [m], velocity v [m/s] and acceleration a [m/s^2], none negative: at time t >= 0 no
            point of the body is farther than r + v t + a t^2 / 2 from its place on the track, before that r.
        until: End of the known time [s]; no motion that ends later is verified.
    """

    track: Track
    error: tuple[float, float, float] = (0.0, 0.0, 0.0)
    until: float = inf

    def __post_init__(self) -> None:
        one_of("track", self.track, Track)
        radius, velocity, acceleration = floats("error", self.error, (3,)).tolist()
        if min(radius, velocity, acceleration) < 0.0:
            raise ShapeError("error", f"must not be negative: {(radius, velocity, acceleration)}")
        object.__setattr__(self, "error", (radius, velocity, acceleration))
        if number("until", self.until, infinite=True) <= 0.0:
            raise ShapeError("until", f"must be after 0 s, is {self.until:g} s")

    @checked
    def error_at(self, time: float) -> float:
        """Return the largest error at a time [m]."""
        radius, velocity, acceleration = self.error
        since = max(time, 0.0)
        return radius + velocity * since + acceleration * since**2 / 2.0

    def shifted(self, time: float) -> Prediction:
        """Return the prediction with the clock advanced by `time` [s].

        Raises:
            ShapeError: If the time is before 0, or not before the end of the known time.
        """
        if not 0.0 <= number("time", time) < self.until:
            raise ShapeError("time", f"must be from 0 to before {self.until:g} s, is {time:g} s")
        _, velocity, acceleration = self.error
        error = (self.error_at(time), velocity + acceleration * time, acceleration)
        return Prediction(self.track.shifted(time), error, self.until - time)

    def __repr__(self) -> str:
        radius, velocity, acceleration = self.error
        known = f", until {self.until:g} s" if isfinite(self.until) else ""
        within = f", within {1e3 * radius:g} mm" if any(self.error) else ""
        grows = f" + {1e3 * velocity:g} mm/s" if velocity or acceleration else ""
        grows += f" + {1e3 * acceleration:g} mm/s^2" if acceleration else ""
        return f"Prediction({self.track}{within}{grows}{known})"


def _unit(vectors: Floats, lengths: Floats) -> Floats:
    still = lengths <= STEADY
    return np.where(still[:, None], (0.0, 0.0, 1.0), vectors / np.where(still, 1.0, lengths)[:, None])


STEPS = 0.125
"""Share of the tolerance reserved for the deviation between steps: smaller steps take longer, larger ones
leave less to the pieces.
"""
ROUNDING = 1e-12
"""Smaller rotations of a piece are rounding errors [rad, rad/s]."""


@dataclass(frozen=True, eq=False)
class FramePieces:
    """The numbers of a track, and its error.

    Attributes:
        coefficients: Of the origin's position, as in a track, shape (4, k, 3) [m].
        error: Largest distance of a point within reach from its place on the track [m].
    """

    times: Floats
    coefficients: Floats
    rotations: Floats
    axes: Floats
    rates: Floats
    error: float


def frame_pieces(
    robot: MovingRobot, trajectory: Trajectory, anchor: Anchor, *, reach: float, tolerance: float
) -> FramePieces:
    """Return pieces of a track that follow a frame.

    Args:
        reach: Of the points that count, from the frame's origin [m].
    """
    bounds = _Bounds.of(robot, trajectory, anchor)
    curvature = bounds.point + reach * bounds.turning
    step = sqrt(8.0 * STEPS * tolerance / curvature) if curvature > 0.0 else inf
    steps = _Steps.of(robot, trajectory, anchor, step)
    ends, error = [0], 0.0
    while ends[-1] < len(steps.times) - 1:
        end, off = steps.longest(ends[-1], reach, bounds, tolerance)
        ends.append(end)
        error = max(error, off)
    return steps.pieces(ends, error)


@dataclass(frozen=True, eq=False)
class _Bounds:
    """Bounds on second derivatives at all times of a motion."""

    point: float
    turning: float

    @staticmethod
    def of(robot: MovingRobot, trajectory: Trajectory, anchor: Anchor) -> _Bounds:
        model = robot.model
        spread = np.abs(robot.mimic_matrix)
        speed, increase = (spread @ _largest(trajectory, order) for order in (1, 2))
        moved = np.abs(robot.mimic_offset) + spread @ _largest(trajectory, 0)
        length = float(np.linalg.norm(anchor.placement.translation))
        velocity = acceleration = rate = turning = 0.0
        for joint in _chain(model, anchor.joint):
            w, a = float(speed[joint - 1]), float(increase[joint - 1])
            if _turns(model, joint):
                acceleration += 2.0 * w * velocity + (w**2 + a) * length
                velocity += w * length
                turning += a + rate * w
                rate += w
            else:
                length += float(moved[joint - 1])
                velocity, acceleration = velocity + w, acceleration + a
            length += float(np.linalg.norm(model.jointPlacements[joint].translation))
        return _Bounds(acceleration, turning + rate**2)


def _chain(model: pin.Model, joint: int) -> list[int]:
    found: list[int] = []
    while joint > 0:
        found.append(joint)
        joint = int(model.parents[joint])
    return found


def _turns(model: pin.Model, joint: int) -> bool:
    data = model.joints[joint].createData()
    model.joints[joint].calc(data, pin.neutral(model))
    return bool(np.abs(np.asarray(data.S, dtype=np.float64).reshape(6)[3:]).max() > 0.5)


def _largest(trajectory: Trajectory, order: int) -> Floats:
    """Bound the magnitudes of positions or a derivative over all times, shape (n,).

    In Bernstein form a polynomial lies between its smallest and largest coefficient (Farin, section 5.1).
    """
    rows = trajectory.coefficients
    for _ in range(order):
        powers = np.arange(len(rows) - 1, 0, -1.0)[:, None, None]
        rows = rows[:-1] * powers if len(rows) > 1 else np.zeros_like(rows)
    degree = len(rows) - 1
    ascending = rows[::-1] * np.diff(trajectory.times)[None, :, None] ** np.arange(degree + 1)[:, None, None]
    shares = np.array(
        [
            [comb(i, k) / comb(degree, k) if k <= i else 0.0 for k in range(degree + 1)]
            for i in range(degree + 1)
        ]
    )
    return np.asarray(np.abs(np.tensordot(shares, ascending, axes=1)).max(axis=(0, 1)), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class _Steps:
    """A frame at many times, between which the trajectory is one polynomial."""

    times: Floats
    points: Floats
    velocities: Floats
    rotations: Floats

    @staticmethod
    def of(robot: MovingRobot, trajectory: Trajectory, anchor: Anchor, longest: float) -> _Steps:
        spans = zip(trajectory.times[:-1].tolist(), trajectory.times[1:].tolist(), strict=True)
        pieces: list[Floats] = [
            np.linspace(begin, end, max(1, ceil((end - begin) / longest)), endpoint=False)
            for begin, end in spans
        ]
        times = np.append(np.concatenate(pieces), trajectory.duration)
        model, data = robot.model, robot.model.createData()
        points, rotations = np.empty((len(times), 3)), np.empty((len(times), 3, 3))
        velocities = np.empty((2, len(times), 3))
        # Just before a time first: where the velocity jumps, a piece ends with what it had.
        moments = (np.nextafter(times, -1.0), times)
        rates = np.stack([trajectory(each, 1) @ robot.mimic_matrix.T for each in moments])
        chain = [joint - 1 for joint in _chain(model, anchor.joint)]
        out = anchor.placement.translation
        for row, positions in enumerate(trajectory(times)):
            pin.computeJointJacobians(model, data, robot.configuration(positions))
            at = data.oMi[anchor.joint]
            points[row] = at.rotation @ out + at.translation
            rotations[row] = at.rotation @ anchor.placement.rotation
            # Of a point at the world's origin, and of the frame's turning; of one joint J is a vector.
            moving = rates[:, row, chain] @ data.J.reshape(6, -1)[:, chain].T
            velocities[:, row] = moving[:, :3] + np.cross(moving[:, 3:], points[row])
        return _Steps(times, points, velocities, rotations)

    def longest(self, begin: int, reach: float, bounds: _Bounds, tolerance: float) -> tuple[int, float]:
        last = len(self.times) - 1
        good, off = begin + 1, self._off(begin, begin + 1, reach, bounds)
        stride = 1
        while stride:
            end = min(good + stride, last)
            found = self._off(begin, end, reach, bounds) if end > good else inf
            if found <= tolerance:
                good, off, stride = end, found, 2 * stride
            else:
                stride //= 2
        return good, off

    def _off(self, begin: int, end: int, reach: float, bounds: _Bounds) -> float:
        times = self.times[begin : end + 1]
        cubic, (axis, rate) = self._cubic(begin, end), self._turn(begin, end)
        since = (times - times[0])[:, None]
        points = ((cubic[0] * since + cubic[1]) * since + cubic[2]) * since + cubic[3]
        angles = rate * since[:, 0]
        turned = self.rotations[begin] @ _rotations(axis, angles)
        apart = np.linalg.norm(turned - self.rotations[begin : end + 1], axis=(1, 2)) / sqrt(2.0)
        off = np.linalg.norm(points - self.points[begin : end + 1], axis=1) + reach * apart
        bends = np.linalg.norm(6.0 * cubic[0] * since[[0, -1]] + 2.0 * cubic[1], axis=1).max()
        curvature = bounds.point + float(bends) + reach * (bounds.turning + rate**2)
        bulge = np.diff(times) ** 2 / 8.0 * curvature
        return float((np.maximum(off[1:], off[:-1]) + bulge).max())

    def _cubic(self, begin: int, end: int) -> Floats:
        h = self.times[end] - self.times[begin]
        chord = (self.points[end] - self.points[begin]) / h
        v0, v1 = self.velocities[1, begin], self.velocities[0, end]
        return np.stack(
            ((v0 + v1 - 2.0 * chord) / h**2, (3.0 * chord - 2.0 * v0 - v1) / h, v0, self.points[begin])
        )

    def _turn(self, begin: int, end: int) -> tuple[Floats, float]:
        vector = as_rotation_vector(self.rotations[begin].T @ self.rotations[end])
        angle = float(np.linalg.norm(vector))
        rate = angle / float(self.times[end] - self.times[begin])
        # What does not turn must not: rounding would give each piece a joint of its own.
        return (
            (vector / angle, rate)
            if rate > ROUNDING and angle > ROUNDING
            else (np.array((0.0, 0.0, 1.0)), 0.0)
        )

    def pieces(self, ends: list[int], error: float) -> FramePieces:
        turns = [self._turn(*pair) for pair in pairwise(ends)]
        return FramePieces(
            self.times[ends],
            np.stack([self._cubic(*pair) for pair in pairwise(ends)], axis=1),
            self.rotations[ends[:-1]],
            np.array([axis for axis, _ in turns]),
            np.array([rate for _, rate in turns]),
            error,
        )


def _rotations(axis: Floats, angles: Floats) -> Floats:
    quarter = from_rotation_vector(axis * (np.pi / 2.0))
    outer = np.outer(axis, axis)
    cross = quarter - outer
    sine, cosine = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    return cosine * (np.eye(3) - outer) + sine * cross + outer


@dataclass(frozen=True, eq=False)
class Timing(Value):
    """Existence and motion of an object, on the clock of the scene.

    Attributes:
        motion: Motion of its frame; None if it rests, or is carried.
        appears: Start of its existence [s].
    """

    motion: Prediction | None = None
    appears: float = -inf
    expires: float = inf

    @property
    def always(self) -> bool:
        """Whether it always exists and does not move."""
        return self.motion is None and self.appears == -inf and self.expires == inf

    def shifted(self, time: float) -> Timing:
        """Return it with the clock advanced by `time` [s]."""
        motion = self.motion if self.motion is None else self.motion.shifted(time)
        return Timing(motion, self.appears - time, self.expires - time)

    def __repr__(self) -> str:
        parts = [] if self.motion is None else [str(self.motion)]
        parts += [f"appears at {self.appears:g} s"] if isfinite(self.appears) else []
        parts += [f"expires at {self.expires:g} s"] if isfinite(self.expires) else []
        return f"Timing({', '.join(parts) or 'always there'})"


ALWAYS = Timing()


def timing_of(
    name: str, motion: Prediction | Track | None, appears: float | None, expires: float | None
) -> Timing:
    """Return the timing of an object; a track alone is a prediction without error and end."""
    if isinstance(motion, Track):
        motion = Prediction(motion)
    if motion is not None and not isinstance(motion, Prediction):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ModelError(f"motion of {shown(name)} must be a Track or a Prediction, is {shown(motion)}")
    begin = -inf if appears is None else number(f"appears of {shown(name)}", appears, infinite=True)
    end = inf if expires is None else number(f"expires of {shown(name)}", expires, infinite=True)
    if begin >= end:
        raise ShapeError(f"expires of {shown(name)}", f"at {end:g} s is not after it appears at {begin:g} s")
    found = Timing(motion, begin, end)
    return ALWAYS if found.always else found
