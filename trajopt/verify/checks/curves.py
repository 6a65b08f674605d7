"""Check that a frame follows a curve, forwards and completely."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import comb

import numpy as np

from trajopt.problem.requirements import FollowsCurve
from trajopt.values.arrays import Bools, Floats, Ints
from trajopt.values.curve import Curve, Piece
from trajopt.values.printed import in_length, in_unit_apart
from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.checks.quantities import Quantity, When, check_requirement, quantities
from trajopt.verify.kernel.motion import JudgedMotion
from trajopt.verify.kernel.relative_motion import RelativeMotion

NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)
"""Of Gauss and Legendre's quadrature from -1 to 1."""
KINK = 0.05
"""Smallest jump of direction that counts as a kink [-], [rad/m]."""


@dataclass(frozen=True, eq=False)
class Bends:
    """Bounds over intervals of a curve, per metre, each of shape (c, 2): for points and orientations.

    Attributes:
        rate: Bound of the first derivative [-], [rad/m].
        second: Bound of the second derivative [1/m], [rad/m^2], away from kinks.
        kinks: Sum of the jumps of the first derivative inside.
    """

    rate: Floats
    second: Floats
    kinks: Floats


class CurvePlaces:
    """Points of a curve and bounds on its curvature.

    Points are vectors of length 3. An orientation C is represented by its three columns, or by one direction
    C a if the frame may spin about a. When C turns with angular velocity w and acceleration v, the first has
    a second derivative of length at most sqrt(2) (|v| + |w|^2), the other one |v| + |w|^2. With C = C_0
    exp(x), |w| <= |x'| and |v| <= |x''| + |x'|^2 / 2, since the Jacobian of rotations is the mean of
    rotations by parts of x.
    """

    def __init__(self, curve: Curve) -> None:
        self._pieces = curve.pieces
        self._points = _stacked([piece.points for piece in curve.pieces])
        self._turns = _stacked([piece.turns for piece in curve.pieces])
        arcs = [(piece.rotation, piece.cosine, piece.sine, piece.sweep) for piece in curve.pieces]
        self._rotation, self._cosine, self._sine, self._sweep = map(np.array, zip(*arcs, strict=True))
        self._length = np.array([piece.length for piece in curve.pieces])
        self.edges = np.append(0.0, np.cumsum(self._length))
        self._rates = np.array([_rates(piece) for piece in curve.pieces])
        self._seconds = np.array([_seconds(piece) for piece in curve.pieces])
        jumps = [_jump(before, after) for before, after in pairwise(curve.pieces)]
        self._kinks = np.concatenate((np.zeros((1, 2)), np.cumsum(np.reshape(jumps, (-1, 2)), axis=0)))

    @property
    def bent(self) -> float:
        """The number of pieces, and of half turns on circles and of orientations."""
        swept = [abs(piece.sweep) + _largest(piece.turns, 1) for piece in self._pieces]
        return len(self._pieces) + sum(swept) / np.pi

    @property
    def kinked(self) -> Floats:
        jumps = np.diff(self._kinks, axis=0).max(axis=1)
        return self.edges[1:-1][jumps > KINK]

    def _number(self, s: Floats) -> Ints:
        found = np.searchsorted(self.edges, s, side="right") - 1
        return np.clip(found, 0, len(self._pieces) - 1).astype(np.int64)

    def at(self, s: Floats) -> tuple[Floats, Floats]:
        """Return rotations (c, 3, 3) and points (c, 3) [m] at arc lengths (c,) [m]."""
        number = self._number(s)
        u = (s - self.edges[number]) / self._length[number]
        angle = (self._sweep[number] * u)[:, None]
        point = _bezier(self._points[number], u)
        point += np.cos(angle) * self._cosine[number] + np.sin(angle) * self._sine[number]
        return self._rotation[number] @ _turns(_bezier(self._turns[number], u)), point

    def bends(self, begin: Floats, end: Floats) -> Bends:
        first = self._number(begin)
        last = np.maximum(first, np.searchsorted(self.edges, end, side="left") - 1)
        rate, second = self._rates[first], self._seconds[first]
        for step in range(1, int((last - first).max(initial=0)) + 1):
            other = np.minimum(first + step, last)
            rate = np.maximum(rate, self._rates[other])
            second = np.maximum(second, self._seconds[other])
        return Bends(rate, second, self._kinks[last] - self._kinks[first])


def _bernstein(degree: int, u: Floats) -> Floats:
    powers = np.arange(degree + 1)
    binomials = np.array([comb(degree, int(k)) for k in powers], dtype=np.float64)
    return binomials * u[:, None] ** powers * (1.0 - u[:, None]) ** (degree - powers)


def _stacked(controls: Sequence[Floats]) -> Floats:
    """Return Bezier polynomials of different degrees as ones of the largest degree, (p, d + 1, 3)."""
    return np.stack([_elevated(control, max(map(len, controls))) for control in controls])


def _elevated(control: Floats, count: int) -> Floats:
    while len(control) < count:
        share, zero = np.arange(len(control) + 1)[:, None] / len(control), np.zeros((1, 3))
        control = share * np.vstack((zero, control)) + (1.0 - share) * np.vstack((control, zero))
    return control


def _bezier(control: Floats, u: Floats) -> Floats:
    return np.einsum("cd,cdi->ci", _bernstein(control.shape[1] - 1, u), control)


def _turns(w: Floats) -> Floats:
    """Return rotation matrices of rotation vectors by Rodrigues' formula, (c, 3) -> (c, 3, 3)."""
    angle = np.linalg.norm(w, axis=1)[:, None, None]
    x, y, z = w.T
    zero = np.zeros_like(x)
    cross = np.stack((zero, -z, y, z, zero, -x, -y, x, zero), axis=1).reshape(-1, 3, 3)
    whole = np.asarray(np.sinc(angle / np.pi), dtype=np.float64)  # sin(a) / a
    half = np.asarray(np.sinc(angle / (2.0 * np.pi)), dtype=np.float64)
    return np.eye(3) + whole * cross + 0.5 * half**2 * (cross @ cross)


def _rates(piece: Piece) -> tuple[float, float]:
    """Bound the first derivatives of point and orientation along a piece [-], [rad/m].

    The derivative of a Bezier polynomial stays within the hull of its control points, the differences times
    the degree.
    """
    arm = max(float(np.linalg.norm(piece.cosine)), float(np.linalg.norm(piece.sine)))
    point = _largest(piece.points, 1) + arm * abs(piece.sweep) * np.sqrt(2.0)
    return point / piece.length, _largest(piece.turns, 1) / piece.length


def _seconds(piece: Piece) -> tuple[float, float]:
    """Bound the second derivatives of the point and of the orientation's rotation vector."""
    arm = max(float(np.linalg.norm(piece.cosine)), float(np.linalg.norm(piece.sine)))
    point = _largest(piece.points, 2) + arm * piece.sweep**2 * np.sqrt(2.0)
    turn = _largest(piece.turns, 2) + _largest(piece.turns, 1) ** 2 / 2.0
    return point / piece.length**2, turn / piece.length**2


def _largest(control: Floats, order: int) -> float:
    degree = len(control) - 1
    if degree < order:
        return 0.0
    factor = float(np.prod(np.arange(degree, degree - order, -1)))
    return factor * float(np.linalg.norm(np.diff(control, n=order, axis=0), axis=1).max())


def _jump(before: Piece, after: Piece) -> tuple[float, float]:
    old, new = _slopes(before, 1.0), _slopes(after, 0.0)
    point, turn = (float(np.linalg.norm(new[row] - old[row])) for row in (0, 1))
    return point, turn


def _slopes(piece: Piece, u: float) -> tuple[Floats, Floats]:
    """Return derivative of the point and angular velocity at an end of a piece, both (3,), per metre."""
    at_end = np.array((u,))
    angle = piece.sweep * u
    point = piece.sweep * (np.cos(angle) * piece.sine - np.sin(angle) * piece.cosine)
    if len(piece.points) > 1:
        slopes = (len(piece.points) - 1) * np.diff(piece.points, axis=0)
        point = point + (_bernstein(len(slopes) - 1, at_end) @ slopes)[0]
    if len(piece.turns) == 1:
        return point / piece.length, np.zeros(3)
    slopes = (len(piece.turns) - 1) * np.diff(piece.turns, axis=0)
    rate = (_bernstein(len(slopes) - 1, at_end) @ slopes)[0]
    x = (_bernstein(len(piece.turns) - 1, at_end) @ piece.turns)[0]
    # The mean of the rotations by parts of x takes x' to the angular velocity (Gauss-Legendre, exact enough).
    mean = np.einsum("c,cij->ij", WEIGHTS / 2.0, _turns((NODES[:, None] + 1.0) / 2.0 * x))
    return point / piece.length, piece.rotation @ mean @ rate / piece.length


FEWEST, MOST = 600, 6000
"""Number of times, and of curve points, of the first estimate."""
EACH = 4
"""Likewise for each piece of the curve, and for each half turn, after which it leads back."""
NEARER = 8
"""Extra points on each side of a kink, each nearer to it than the last."""
TOWARDS = 0.5
"""Ratio of successive distances of these points from the kink."""
SAME = 1e-9
"""Distance below which points coincide [m]."""
ROUNDS = 4
"""Newton steps from the first estimate."""
DIFFERENCE = 1e-5
"""Step of the finite difference for the curve's direction [m]."""


@dataclass(frozen=True, eq=False)
class Errors:
    """Differences between a frame and points of a curve, as vectors.

    Attributes:
        placements: Times (c,) -> rotation (c, 3, 3) and point (c, 3) [m] of the frame.
    """

    required: FollowsCurve
    places: CurvePlaces
    placements: Callable[[Floats], tuple[Floats, Floats]]

    @property
    def spread(self) -> float:
        return 1.0 if self.required.spin is not None else float(np.sqrt(2.0))

    def chord(self, angle: float) -> float:
        """Convert angles to lengths of differences of orientation vectors."""
        return 2.0 * self.spread * float(np.sin(min(angle, np.pi) / 2.0))

    def angle(self, chord: float) -> float:
        return 2.0 * float(np.arcsin(min(chord / (2.0 * self.spread), 1.0)))

    def frame(self, times: Floats) -> Floats:
        return self._vector(*self.placements(times))

    def curve(self, s: Floats) -> Floats:
        return self._vector(*self.places.at(s))

    def sizes(self, times: Floats, s: Floats) -> Floats:
        return self.lengths(self.frame(times) - self.curve(s))

    def lengths(self, apart: Floats) -> Floats:
        """Return lengths of both parts of differences (c, 6 or 12), (c, 2); 0 for a free orientation."""
        found = np.stack((np.linalg.norm(apart[:, :3], axis=1), np.linalg.norm(apart[:, 3:], axis=1)), axis=1)
        if np.isinf(self.required.rotation_tolerance):
            found[:, 1] = 0.0
        return found

    def at(self, times: Floats, s: Floats) -> Floats:
        """Return distances [m] and angles [rad], shape (c, 2)."""
        found = self.sizes(times, s)
        found[:, 1] = [self.angle(chord) for chord in found[:, 1].tolist()]
        return found

    @property
    def weights(self) -> Floats:
        turned = self.required.rotation_tolerance
        by_turn = 0.0 if np.isinf(turned) else 1.0 / self.chord(turned)
        columns = 3 if self.required.spin is not None else 9
        return np.concatenate((np.full(3, 1.0 / self.required.position_tolerance), np.full(columns, by_turn)))

    @property
    def count(self) -> int:
        return int(np.clip(EACH * self.places.bent, FEWEST, MOST))

    def candidate_fractions(self, until: float) -> Floats:
        edges, step = self.places.edges, until / (self.count - 1)
        nearer = step * TOWARDS ** np.arange(1, NEARER + 1)
        around = self.places.kinked[:, None] + np.concatenate((-nearer, nearer))
        found = np.concatenate((np.linspace(0.0, until, self.count), edges, around.ravel()))
        found = np.unique(found[(found >= 0.0) & (found <= until)])
        # Two that differ by rounding only would leave no room between neighbours.
        return found[np.append(True, np.diff(found) > SAME)]

    def _vector(self, rotation: Floats, point: Floats) -> Floats:
        spin = self.required.spin
        turned = rotation.reshape(-1, 9) if spin is None else rotation @ spin
        return np.concatenate((point, turned), axis=1)


def nearest_progress(errors: Errors, motion: JudgedMotion, until: float) -> tuple[Floats, Floats]:
    """Estimate the frame's progress along the curve: times and arc lengths, (c,) each.

    Any non-decreasing function is a witness, and `follow` bounds its errors. It minimises the sum of squared
    errors on a grid (dynamic time warping), from the beginning of the curve to `until`. Among the times are
    the rests of the motion, as even times miss the ends of short folds.
    """
    at_rest = (motion.group[1].coefficients[-1] == 0.0).all(axis=1)
    rests = motion.trajectory.times[:-1][at_rest]
    times = np.unique(np.concatenate((np.linspace(0.0, motion.duration, errors.count), rests)))
    s = errors.candidate_fractions(until)
    weights = errors.weights
    frame, curve = errors.frame(times) * weights, errors.curve(s) * weights
    size = (curve**2).sum(axis=1)
    cost = np.append(0.0, np.full(len(s) - 1, np.inf))
    came_from = np.zeros((len(times), len(s)), dtype=np.int32)
    columns = np.arange(len(s), dtype=np.int32)
    for row in range(1, len(times)):
        least = np.minimum.accumulate(cost)
        came_from[row] = np.maximum.accumulate(np.where(cost == least, columns, 0))
        cost = least + (size - 2.0 * curve @ frame[row])
    column = np.empty(len(times), dtype=np.int64)
    column[-1] = len(s) - 1
    for row in range(len(times) - 1, 0, -1):
        column[row - 1] = came_from[row, column[row]]
    low, high = s[np.maximum(column - 1, 0)], s[np.minimum(column + 1, len(s) - 1)]
    found = refined(errors, times, s[column], low, high)
    found[0], found[-1] = 0.0, until
    return times, np.minimum(np.maximum.accumulate(found), until)


def refined(errors: Errors, times: Floats, s: Floats, low: Floats, high: Floats) -> Floats:
    """Move points along the curve to the nearest points of the frame, between bounds; all of shape (c,).

    Both sides of a kink are tried, as either leg may be nearer at a sharp corner.
    """
    edges, frame = errors.places.edges, errors.frame(times)
    last = len(edges) - 1
    first_end = np.minimum(high, edges[np.minimum(np.searchsorted(edges, low, side="right"), last)])
    last_begin = np.maximum(low, edges[np.maximum(np.searchsorted(edges, high, side="left") - 1, 0)])
    sides = (
        _nearest(errors, frame, np.clip(s, low, first_end), low, first_end),
        _nearest(errors, frame, np.clip(s, last_begin, high), last_begin, high),
    )
    off = [(((frame - errors.curve(side)) * errors.weights) ** 2).sum(axis=1) for side in sides]
    return np.where(off[0] <= off[1], *sides)


def _nearest(errors: Errors, frame: Floats, s: Floats, low: Floats, high: Floats) -> Floats:
    weights = errors.weights
    found, share = s.copy(), np.ones(len(s))
    off = (frame - errors.curve(found)) * weights
    for _ in range(ROUNDS):
        back, on = np.maximum(found - DIFFERENCE, low), np.minimum(found + DIFFERENCE, high)
        step = np.maximum(on - back, 1e-12)[:, None]
        slope = (errors.curve(on) - errors.curve(back)) / step * weights
        square = (slope**2).sum(axis=1)
        gain = share * (slope * off).sum(axis=1) / np.where(square > 0.0, square, 1.0)
        tried = np.clip(found + gain, low, high)
        nearer = (frame - errors.curve(tried)) * weights
        better = (nearer**2).sum(axis=1) < (off**2).sum(axis=1)
        found, off = np.where(better, tried, found), np.where(better[:, None], nearer, off)
        share = np.where(better, 1.0, share / 4.0)
    return found


PIECES = 4
"""Number of parts into which an unproven interval is cut."""
MOST_INTERVALS = 400_000
"""Intervals after which the search for a proof ends."""


@dataclass(frozen=True, eq=False)
class _Span:
    begin: Floats
    end: Floats
    first: Floats
    last: Floats

    def take(self, mask: Bools) -> "_Span":
        return _Span(self.begin[mask], self.end[mask], self.first[mask], self.last[mask])


@dataclass(frozen=True, eq=False)
class CurveFinding:
    """Distance from a curve over all times.

    Attributes:
        worst: Largest measured error of position [m] and rotation [rad], shape (2,).
        time: Times of these measurements, shape (2,) [s].
    """

    worst: Floats
    time: Floats
    unproven: tuple[tuple[float, float] | None, tuple[float, float] | None]


@check_requirement.register
def _(requirement: FollowsCurve, motion: JudgedMotion, when: When) -> tuple[Check, ...]:
    errors = _errors(requirement, motion)
    if when is When.END:
        at = errors.at(np.array((motion.duration,)), np.array((requirement.until,)))[0]
        found = CurveFinding(at, np.full(2, motion.duration), (None, None))
    else:
        found = follow(requirement, motion)
    tolerances = (requirement.position_tolerance, requirement.rotation_tolerance)
    judged = range(1 if np.isinf(requirement.rotation_tolerance) else 2)
    return tuple(
        _check(requirement, motion, when, found, which=which, tolerance=tolerances[which]) for which in judged
    )


def _check(
    requirement: FollowsCurve,
    motion: JudgedMotion,
    when: When,
    found: CurveFinding,
    *,
    which: int,
    tolerance: float,
) -> Check:
    value, unit = float(found.worst[which]), ("m", "rad")[which]
    gap = found.unproven[which]
    exceeded = value > tolerance + motion.options.excess
    evidence = Evidence.SAMPLED if exceeded else Evidence.PROVEN if gap is None else Evidence.UNPROVEN
    here, accepted = in_unit_apart(value, tolerance, unit)
    text = f"{('distance', 'turn')[which]} from the curve is {here}, {accepted} is accepted; along "
    text += f"{in_length(requirement.until)} of {in_length(requirement.curve.length)}, never backwards"
    if gap is not None:
        text += f"; no proof from {gap[0]:.5f} to {gap[1]:.5f} s"
    return Check(
        kind=(CheckKind.CURVE_POSITION, CheckKind.CURVE_ROTATION)[which],
        name=f"{when.value}: curve {('position', 'rotation')[which]}",
        subject=requirement.frame,
        value=value,
        bound=tolerance,
        unit=unit,
        time=float(found.time[which]),
        slack=tolerance - value,
        evidence=evidence,
        holds=evidence is Evidence.PROVEN,
        detail=text,
    )


def follow(requirement: FollowsCurve, motion: JudgedMotion) -> CurveFinding:
    """Find a non-decreasing witness s(t) of the frame's progress along the curve, and bound its errors.

    The witness is linear between times. With h the length of a time interval and f the difference of the
    placements of the frame and of the curve at s(t), |f| is at most its largest value at the two ends, plus
    h^2 / 8 times a bound of its second derivative, plus h / 4 times the jumps of its first derivative at
    kinks of the curve.
    """
    errors = _errors(requirement, motion)
    moving = RelativeMotion(
        motion, requirement.frame, reference=requirement.reference, offset=requirement.offset
    )
    times, s = nearest_progress(errors, motion, requirement.until)
    limit = np.array((requirement.position_tolerance, errors.chord(requirement.rotation_tolerance)))
    limit = limit + motion.options.excess
    worst, when = np.full(2, -np.inf), np.zeros(2)
    unproven: list[tuple[float, float] | None] = [None, None]
    span, total = _Span(times[:-1], times[1:], s[:-1], s[1:]), 0
    while len(span.begin):
        total += len(span.begin)
        at_ends = [errors.sizes(*ends) for ends in ((span.begin, span.first), (span.end, span.last))]
        for sizes, moments in zip(at_ends, (span.begin, span.end), strict=True):
            rows = sizes.argmax(axis=0)
            for which, row in enumerate(rows.tolist()):
                if sizes[row, which] > worst[which]:
                    worst[which], when[which] = sizes[row, which], moments[row]
        if (worst > limit).any():
            break
        left = np.maximum(*at_ends) + _bulge(errors, moving, span) > limit
        again = np.asarray(left.any(axis=1), dtype=np.bool_)
        span, left = span.take(again), left[again]
        narrow = bool((span.end - span.begin < PIECES * motion.options.smallest_interval).any())
        if len(span.begin) and (narrow or total > MOST_INTERVALS):
            for which in (0, 1):
                rows = np.flatnonzero(left[:, which])
                if len(rows):
                    unproven[which] = float(span.begin[rows[0]]), float(span.end[rows[0]])
            break
        span = _cut(errors, span)
    worst[1] = errors.angle(worst[1])
    return CurveFinding(worst, when, (unproven[0], unproven[1]))


def _errors(requirement: FollowsCurve, motion: JudgedMotion) -> Errors:
    moving = RelativeMotion(
        motion, requirement.frame, reference=requirement.reference, offset=requirement.offset
    )
    return Errors(requirement, CurvePlaces(requirement.curve), moving.placements)


def _bulge(errors: Errors, moving: RelativeMotion, span: _Span) -> Floats:
    """Bound the rise of errors inside intervals above their ends, shape (c, 2)."""
    rates, length = moving.bounds(span.begin, span.end), span.end - span.begin
    bends = errors.places.bends(span.first, span.last)
    speed = ((span.last - span.first) / length)[:, None]
    turning = rates.turn_acceleration + rates.turn_rate**2
    curve = bends.second * speed**2
    curve[:, 1] += (bends.rate[:, 1] * speed[:, 0]) ** 2
    second = np.stack((rates.point_acceleration, turning), axis=1) + curve
    bulge = second * length[:, None] ** 2 / 8.0 + bends.kinks * speed * length[:, None] / 4.0
    bulge[:, 1] *= errors.spread
    return bulge


def _cut(errors: Errors, span: _Span) -> _Span:
    part = np.arange(PIECES + 1) / PIECES
    times = span.begin[:, None] + (span.end - span.begin)[:, None] * part
    s = span.first[:, None] + (span.last - span.first)[:, None] * part
    inner = (slice(None), slice(1, -1))
    low, high = (np.repeat(side, PIECES - 1) for side in (span.first, span.last))
    s[inner] = refined(errors, times[inner].ravel(), s[inner].ravel(), low, high).reshape(-1, PIECES - 1)
    s = np.maximum.accumulate(s, axis=1)
    return _Span(times[:, :-1].ravel(), times[:, 1:].ravel(), s[:, :-1].ravel(), s[:, 1:].ravel())


@quantities.register
def _(requirement: FollowsCurve, motion: JudgedMotion) -> tuple[Quantity, ...]:
    errors = _errors(requirement, motion)

    curve = errors.curve(errors.candidate_fractions(requirement.until))
    tolerances = np.array((requirement.position_tolerance, errors.chord(requirement.rotation_tolerance)))

    def excess(frame: Floats) -> Floats:
        found = np.full(len(frame), np.inf)
        for place in curve:
            over = errors.lengths(frame - place) - tolerances
            found = np.minimum(found, over.max(axis=1))
        return found

    return (
        Quantity(
            kind="curve",
            name="distance from the curve beyond the tolerance",
            subject=requirement.frame,
            unit="",
            limit=0.0,
            states=errors.frame,
            number=excess,
            bound=None,
        ),
    )
