"""Pieces of a track that follow a frame of a robot, with a proven bound on how far they are from it.

A track has pieces: in each the origin moves along a cubic through the positions and velocities at its ends,
and the frame turns evenly from one end to the other. Let D(t) be how far any point within r of the origin is
from where the track has it. With p and R the frame's position and rotation, P and S those of the track,

    D <= |p - P| + r |R - S|,    |R - S| = 2 sin(angle between R and S / 2).

Both differences are curves. They are measured at the ends of short steps of length h, inside which the
trajectory is one polynomial, and between these they leave their chord by h^2 / 8 times their largest second
derivative at most. So in all of a step

    D <= max(D at its two ends) + h^2 / 8 (max |p''| + max |P''| + r (max |R''| + rate^2)).

Seen from the outermost joint inwards, a joint that turns at rate w and accelerates by a, no farther than l
from the point, adds 2 w |p'| + (w^2 + a) l to |p''| and w l to |p'|; |R''| is at most the square of the sum
of all rates, and the angular acceleration. Pieces are as long as D stays within the tolerance.
"""

from dataclasses import dataclass
from itertools import pairwise
from math import ceil, comb, inf, sqrt

import numpy as np
import pinocchio as pin

from trajopt.robot.bodies import Anchor
from trajopt.scene.planned_robot import MovingRobot
from trajopt.values.arrays import Floats
from trajopt.values.rotations import as_rotation_vector, from_rotation_vector
from trajopt.values.trajectory import Trajectory

STEPS = 0.125
"""Share of the tolerance that is left for what is between the steps: shorter ones take time, longer ones
leave less to the pieces."""
ROUNDING = 1e-12
"""Smaller turns of a piece are rounding, and slower ones would never be seen [rad, rad/s]."""


@dataclass(frozen=True, eq=False)
class FramePieces:
    """The numbers of a track, and how far it is from what it follows.

    Attributes:
        times: Ends of the k pieces, increasing, shape (k + 1,) [s].
        coefficients: Of the origin's position, as those of a track, shape (4, k, 3) [m].
        rotations: At the start of each piece, shape (k, 3, 3).
        axes: Unit vector about which it turns in each piece, in its own frame, shape (k, 3).
        rates: How fast it does, shape (k,) [rad/s].
        error: No point within reach is ever farther from where the track has it [m].
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
        robot: What moves.
        trajectory: Of its group's joints.
        anchor: The joint that carries the frame, and where in it.
        reach: Of the points that count, from the frame's origin [m].
        tolerance: How far they may be from where the track has them [m].
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
    """Bounds on second derivatives that hold at all times of a motion.

    Attributes:
        point: Acceleration of a frame's origin [m/s^2].
        turning: Of the frame's rotation matrix [1/s^2].
    """

    point: float
    turning: float

    @staticmethod
    def of(robot: MovingRobot, trajectory: Trajectory, anchor: Anchor) -> "_Bounds":
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
    """Return a joint and those it hangs on, outermost first."""
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
    """Bound the sizes of positions or a derivative over all times, shape (n,).

    In Bernstein form a polynomial lies between its smallest and its largest control value.
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
    """A frame at many times, between which the trajectory is one polynomial.

    Attributes:
        times: Shape (s,) [s].
        points: Of its origin, shape (s, 3) [m].
        velocities: Of its origin, just before and just after each time, shape (2, s, 3) [m/s].
        rotations: Shape (s, 3, 3).
    """

    times: Floats
    points: Floats
    velocities: Floats
    rotations: Floats

    @staticmethod
    def of(robot: MovingRobot, trajectory: Trajectory, anchor: Anchor, longest: float) -> "_Steps":
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
        """Return where the longest piece within the tolerance ends, and how far points are from it [m]."""
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
        """Bound how far points are from a piece between two steps."""
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
        """Return the cubic through positions and velocities at two steps, highest power first, (4, 3)."""
        h = self.times[end] - self.times[begin]
        chord = (self.points[end] - self.points[begin]) / h
        v0, v1 = self.velocities[1, begin], self.velocities[0, end]
        return np.stack(
            ((v0 + v1 - 2.0 * chord) / h**2, (3.0 * chord - 2.0 * v0 - v1) / h, v0, self.points[begin])
        )

    def _turn(self, begin: int, end: int) -> tuple[Floats, float]:
        """Return the axis and the rate [rad/s] of the even turn between two steps."""
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
        """Return the pieces between these steps."""
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
    """Return turns about one axis, (s,) -> (s, 3, 3), by Rodrigues' formula."""
    quarter = from_rotation_vector(axis * (np.pi / 2.0))
    outer = np.outer(axis, axis)
    cross = quarter - outer
    sine, cosine = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    return cosine * (np.eye(3) - outer) + sine * cross + outer
