"""Tracking of a curve from first configurations, stepwise, without jumps."""

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from trajopt.geometry import Evaluator
from trajopt.optimise.terms.frame_placement import CurveError
from trajopt.optimise.terms.frames import relative_frame
from trajopt.planning.budget import Budget, BudgetTracker
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import FollowsCurve
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Bools, Floats
from trajopt.values.curve import TURN_LENGTH

HELD = 1e-8
"""Accepted error of a point; see `OnCurve.turn_length` [m]."""
STEPS = 14
"""Most Newton steps."""
LONGEST = 0.3
"""Longest step of any joint [rad | m]."""
SINGULAR = 1e-3
"""Singular values below this share of the largest are damped [-]."""
TILTED = 0.7
"""Share of the tolerance of rotation that a tilt may use: the rest is for chords and rounded corners."""
NO_MOTION = 1e-6
"""Singular values below this share of the largest, and needed motions below this share, count as none [-]."""
LEAST_TURN_LENGTH = 0.01
"""Smallest length of a radian: rows of rotations below `SINGULAR` would be damped [m/rad]."""
DISTANCE_ROW = 3
"""The row of the error with the distance, which the previous three imply."""


@dataclass(frozen=True, eq=False)
class Corrected:
    """Result of Newton's method for S configurations.

    Attributes:
        positions: Shape (S, n) [rad | m], inside the limits.
        miss: Error of the frame, rotations counted as lengths, shape (S,) [m].
    """

    positions: Floats
    miss: Floats

    @property
    def held(self) -> Bools:
        return np.asarray(self.miss <= HELD, dtype=np.bool_)


class OnCurve:
    """Moves configurations to points of a curve with least joint motion.

    Attributes:
        tilt: Angle from the orientation of the curve that does not count as an error [rad].
        tracker: Ends the work when the budget is used up; unlimited if None.
    """

    def __init__(
        self,
        reduced: ReducedModel,
        required: FollowsCurve,
        query: Evaluator,
        tracker: BudgetTracker | None = None,
        tilt: float = 0.0,
    ) -> None:
        self.reduced, self.required, self.query = reduced, required, query
        self.tracker = tracker or BudgetTracker(Budget())
        self.tilt = tilt
        self.limits = reduced.limits
        self._term = CurveError(reduced, required)

    def along(self, required: FollowsCurve, reduced: ReducedModel | None = None) -> "OnCurve":
        return OnCurve(reduced or self.reduced, required, self.query, self.tracker, self.tilt)

    def tilting(self) -> "OnCurve":
        """Return the curve with most of its tolerance of rotation as a freedom."""
        return OnCurve(
            self.reduced, self.required, self.query, self.tracker, TILTED * self.required.rotation_tolerance
        )

    @contextmanager
    def stage(self, name: str) -> Generator[None]:
        with self.tracker.stage(name):
            try:
                yield
            finally:
                counts = self.query.counts
                self.tracker.count_work(counts)
                counts.forward_kinematics = counts.bounds = counts.distances = 0

    def without_limits(self) -> "OnCurve":
        free = self.along(self.required)
        boundless = np.full(len(self.limits.joint_names), np.inf)
        free.limits = replace(self.limits, lower=-boundless, upper=boundless)
        return free

    @property
    def rows(self) -> int:
        """Number of fixed coordinates of a point: 6, 5 with a free spin, 3 with a free rotation."""
        if np.isinf(self.required.rotation_tolerance):
            return 3
        return 6 if self.required.spin is None else 5

    @property
    def turn_length(self) -> float:
        """Length of a radian: the ratio of the tolerances within bounds [m/rad]."""
        ratio = self.required.position_tolerance / self.required.rotation_tolerance
        return min(max(ratio, LEAST_TURN_LENGTH), TURN_LENGTH) if ratio > 0.0 else 1.0

    @property
    def allowed(self) -> float:
        return self.required.position_tolerance

    @property
    def spare(self) -> int:
        return max(len(self.reduced.joint_names) - self.rows, 0)

    def errors(self, positions: Floats, s: Floats) -> tuple[Floats, Floats]:
        """Return errors at lengths along the curve (S,): (S, rows) [m], and Jacobians (S, rows, n)."""
        value, jacobian = self._term.errors(Motion.each(positions, self.query), s)
        value, jacobian = (np.delete(each, DISTANCE_ROW, axis=1) for each in (value, jacobian))
        if self.tilt > 0.0 and self.rows > 3:
            # Only the angle counts, and only what is beyond the cone.
            angle = np.linalg.norm(value[:, 3:], axis=1)
            beyond = np.maximum(angle - self.tilt, 0.0)
            outward = value[:, 3:] / np.maximum(angle, 1e-12)[:, None]
            by_angle = np.einsum("sr,srj->sj", outward, jacobian[:, 3:]) * (beyond > 0.0)[:, None]
            value[:, 3:] = beyond[:, None] * outward
            jacobian[:, 3:] = outward[:, :, None] * by_angle[:, None]
        value[:, 3:] *= self.turn_length
        jacobian[:, 3:] *= self.turn_length
        return value, jacobian

    def off(self, positions: Floats, s: Floats) -> tuple[Floats, Floats]:
        value, _ = self.errors(positions, s)
        turn = np.linalg.norm(value[:, 3:], axis=1) / self.turn_length
        return np.linalg.norm(value[:, :3], axis=1), turn

    def points(self, positions: Floats) -> Floats:
        need, motion = self.required, Motion.each(positions, self.query)
        return relative_frame(self.reduced, motion, need.frame, need.reference, need.offset).point

    def apart(self, first: Floats, second: Floats) -> Floats:
        """Return the distance of the frame between two sets of configurations (S, n), shape (S,) [m]."""
        need = self.required
        one, other = (
            relative_frame(self.reduced, Motion.each(q, self.query), need.frame, need.reference, need.offset)
            for q in (first, second)
        )
        far = np.linalg.norm(one.point - other.point, axis=1)
        if np.isinf(need.rotation_tolerance):
            return np.asarray(far, dtype=np.float64)
        if need.spin is not None:
            turned = np.linalg.norm((one.rotation - other.rotation) @ need.spin, axis=1)
        else:
            turned = np.linalg.norm(one.rotation - other.rotation, axis=(1, 2)) / np.sqrt(2.0)
        return np.asarray(np.maximum(far, turned * self.turn_length), dtype=np.float64)

    def __call__(self, positions: Floats, s: Floats) -> Corrected:
        self.tracker.check(self.query.counts)
        limits = self.limits
        q = np.clip(positions, limits.lower, limits.upper)
        miss = np.full(len(q), np.inf)
        going = np.arange(len(q))
        for count in range(STEPS + 1):
            value, jacobian = self.errors(q[going], s[going])
            miss[going] = np.linalg.norm(value, axis=1)
            left = miss[going] > HELD
            going = going[left]
            if count == STEPS or len(going) == 0:
                break
            step = self._step(q[going], value[left], jacobian[left])
            q[going] = np.clip(q[going] + step, limits.lower, limits.upper)
        return Corrected(q, miss)

    def _step(self, q: Floats, value: Floats, jacobian: Floats) -> Floats:
        limits = self.limits
        step = -_damped(jacobian, value)
        for _ in range(2):
            pressed = ((q <= limits.lower) & (step < 0.0)) | ((q >= limits.upper) & (step > 0.0))
            if not pressed.any():
                break
            step = -_damped(np.where(pressed[:, None, :], 0.0, jacobian), value)
        largest = np.abs(step).max(axis=1, keepdims=True)
        return step * np.minimum(1.0, LONGEST / np.maximum(largest, LONGEST))

    def free_motion(self, q: Floats, s: Floats, wish: Floats) -> Floats:
        _, jacobian = self.errors(q, s)
        moved = np.einsum("sij,sj->si", jacobian, wish)
        return wish - _damped(jacobian, moved)

    def free_direction(self, q: Floats, s: Floats) -> Floats:
        _, jacobian = self.errors(q, s)
        return np.asarray(np.linalg.svd(jacobian)[2][:, -1], dtype=np.float64)

    def lacking(self, positions: Floats, s: float, ahead: float) -> tuple[Floats, Floats] | None:
        """Return the motion from length `s` to `ahead` along the curve that no motion of the joints makes.

        Returns:
            Shares of translation and rotation, along and about the axes of the frame, each shape (3,); None
            if the joints make all of it.
        """
        value, jacobian = self.errors(np.tile(positions, (2, 1)), np.array((s, ahead)))
        left, sizes, _ = np.linalg.svd(np.asarray(jacobian[0], dtype=np.float64), full_matrices=True)
        lost = left[:, int((sizes > NO_MOTION * sizes[0]).sum()) :]
        needed = value[0] - value[1]
        missing: Floats = lost @ (lost.T @ needed)
        size = float(np.linalg.norm(missing))
        if size <= NO_MOTION * float(np.linalg.norm(needed)):
            return None
        missing /= size
        return missing[:3], self._term.axes_of_rotation.T @ missing[3:]

    def smallest_singular_value(self, q: Floats, s: Floats) -> Floats:
        _, jacobian = self.errors(q, s)
        sizes = np.asarray(np.linalg.svd(jacobian, compute_uv=False), dtype=np.float64)
        return sizes[:, min(self.rows, q.shape[1]) - 1]


def _damped(jacobian: Floats, value: Floats) -> Floats:
    u, sizes, v = np.linalg.svd(jacobian, full_matrices=False)
    floor = SINGULAR * np.maximum(sizes[:, :1], 1e-12)
    gain = sizes / np.maximum(sizes**2, floor**2)
    return np.asarray(np.einsum("sij,si->sj", v, gain * np.einsum("sji,sj->si", u, value)), dtype=np.float64)


STEP = 0.01
"""Length of a step along the curve [m]."""
MOST_STEPS = 400
"""Most steps along a curve."""
LEAST_STEPS = 8
"""Fewest steps along a curve."""
FARTHEST = 0.2
"""Largest joint motion in a step [rad | m]; a larger one may be a jump."""
HALVINGS = 7
"""Number of halvings of a step before the rest counts as a jump."""
DRIFT = 4.0
"""Rate of the drift to the posture, per metre along the curve [1/m]."""


@dataclass(frozen=True, eq=False)
class CurveTrack:
    """A path of the joints along a curve.

    Attributes:
        stations: Lengths along the curve, increasing from 0, shape (m,) [m].
        positions: Configurations there, shape (m, n) [rad | m].
    """

    stations: Floats
    positions: Floats

    @property
    def reached(self) -> float:
        return float(self.stations[-1])

    def until(self, s: float) -> "CurveTrack":
        kept = max(int(np.searchsorted(self.stations, s + 1e-12, side="right")), 1)
        return CurveTrack(self.stations[:kept], self.positions[:kept])


def stations_of(on_curve: OnCurve) -> Floats:
    edges = on_curve.required.curve.edges
    until = on_curve.required.until
    edges = np.append(edges[edges < until], until)
    step = max(STEP, until / MOST_STEPS)
    least = int(np.ceil(LEAST_STEPS / max(len(edges) - 1, 1)))
    spans = np.diff(edges)
    parts = np.maximum(np.ceil(spans / step), least)
    # The whole part of a count is the number of a piece, and the rest of it where in the piece.
    counted = np.interp(np.arange(int(parts.sum())), np.append(0.0, np.cumsum(parts)), np.arange(len(edges)))
    return np.append(np.interp(counted, np.arange(len(edges)), edges), until)


def track(on_curve: OnCurve, stations: Floats, begin: Floats, pull: Floats) -> list[CurveTrack]:
    """Track the curve from several first configurations.

    Args:
        begin: Configurations at the first of them, shape (b, n) [rad | m].
        pull: Posture of each drift, shape (b, n); NaN for no drift.
    """
    count = len(begin)
    q, alive = begin.copy(), np.ones(count, dtype=np.bool_)
    places: list[list[float]] = [[float(stations[0])] for _ in range(count)]
    ways: list[list[Floats]] = [[begin[branch]] for branch in range(count)]
    for s, after in pairwise(stations.tolist()):
        going = np.flatnonzero(alive)
        if len(going) == 0:
            break
        now = q[going]
        estimate = now + _drift(on_curve, now, s, after - s, pull[going])
        ended = on_curve(estimate, np.full(len(going), after))
        smooth = ended.held & (np.abs(ended.positions - now).max(axis=1) <= FARTHEST)
        for row, branch in enumerate(map(int, going)):
            if smooth[row]:
                reached, place = ended.positions[row], after
            else:
                reached, place = _finely(on_curve, now[row], s, after)
                alive[branch] = place == after
            if place > s:
                q[branch] = reached
                places[branch].append(place)
                ways[branch].append(reached)
    return [CurveTrack(np.array(place), np.array(way)) for place, way in zip(places, ways, strict=True)]


def _drift(on_curve: OnCurve, q: Floats, s: float, step: float, pull: Floats) -> Floats:
    drifting = np.isfinite(pull).all(axis=1)
    moved = np.zeros_like(q)
    if on_curve.spare and drifting.any():
        wish = np.clip((pull - q)[drifting] * DRIFT * step, -DRIFT * step, DRIFT * step)
        moved[drifting] = on_curve.free_motion(q[drifting], np.full(int(drifting.sum()), s), wish)
    return moved


def _finely(on_curve: OnCurve, q: Floats, begin: float, end: float) -> tuple[Floats, float]:
    s, step, least = begin, end - begin, (end - begin) / 2**HALVINGS
    while s < end and step >= least:
        after = end if s + step >= end - 0.5 * least else s + step
        ended = on_curve(q[None], np.array((after,)))
        moved = float(np.abs(ended.positions[0] - q).max())
        if ended.held[0] and moved <= FARTHEST * max(step / (end - begin), 0.05) * 4.0:
            q, s = ended.positions[0], after
            step = min(2.0 * step, end - begin)
        else:
            step /= 2.0
    return q, s


ROUNDS = 9
"""Most bisections."""
APART = 2e-3
"""Largest distance of a chord from the curve's configuration half-way [rad | m]."""


def densified(on_curve: OnCurve, found: CurveTrack, *, tolerance: float) -> CurveTrack:
    """Add knots until the chords between them are near enough to the curve.

    Args:
        tolerance: Largest distance of the frame from the curve half-way between knots, rotations counted as
            lengths [m].
    """
    s = found.stations
    q = np.concatenate((found.positions[:1], on_curve(found.positions[1:], s[1:]).positions))
    doubtful = np.ones(len(s) - 1, dtype=np.bool_)
    for _ in range(ROUNDS):
        left = np.flatnonzero(doubtful)
        if len(left) == 0:
            break
        middle = (s[left] + s[left + 1]) / 2.0
        straight = (q[left] + q[left + 1]) / 2.0
        value, _ = on_curve.errors(straight, middle)
        exact = on_curve(_interpolated(s, q, middle), middle)
        apart = np.abs(exact.positions - straight).max(axis=1)
        coarse = ((np.linalg.norm(value, axis=1) > tolerance) | (apart > APART)) & exact.held
        places = left[coarse] + 1
        s = np.insert(s, places, middle[coarse])
        q = np.insert(q, places, exact.positions[coarse], axis=0)
        marks = np.zeros(len(doubtful), dtype=np.bool_)
        marks[left[coarse]] = True
        doubtful = np.repeat(marks, np.where(marks, 2, 1))
    return CurveTrack(s, q)


def _interpolated(s: Floats, q: Floats, places: Floats) -> Floats:
    from scipy.interpolate import PchipInterpolator

    return np.asarray(PchipInterpolator(s, q)(places), dtype=np.float64)


def resampled(on_curve: OnCurve, found: CurveTrack, stations: Floats) -> CurveTrack:
    estimate = np.concatenate(
        (found.positions[:1], _interpolated(found.stations, found.positions, stations[1:]))
    )
    moved = on_curve(estimate[1:], stations[1:]).positions
    return CurveTrack(stations, np.concatenate((estimate[:1], moved)))
