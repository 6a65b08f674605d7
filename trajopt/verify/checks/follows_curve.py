"""The judge's check of `FollowsCurve`: a non-decreasing witness s(t), and a proof that the frame keeps to it.

The witness is straight between times. With h the length of an interval of time and f the difference of what
the frame does and what the curve does at s(t), |f| is at most its largest value at the two ends, plus h^2 / 8
times a bound of its second derivative, plus h / 4 times the jumps of its first derivative where the curve
has a kink.
"""

from dataclasses import dataclass

import numpy as np

from trajopt.problem.requirements import FollowsCurve
from trajopt.values.arrays import Bools, Floats
from trajopt.values.printed import in_length, in_unit_apart
from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.checks.curve_places import CurvePlaces
from trajopt.verify.checks.progress import Errors, nearest_progress, refined
from trajopt.verify.checks.quantities import Quantity, check_requirement, quantities
from trajopt.verify.checks.requirement import When
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.kernel.relative_motion import RelativeMotion

PIECES = 4
"""Into how many parts an interval without proof is cut."""
MOST_INTERVALS = 400_000
"""Intervals examined before the search for a proof is given up."""


@dataclass(frozen=True, eq=False)
class _Span:
    """Intervals of time and of the curve, each of shape (c,)."""

    begin: Floats
    end: Floats
    first: Floats
    last: Floats

    def take(self, mask: Bools) -> "_Span":
        return _Span(self.begin[mask], self.end[mask], self.first[mask], self.last[mask])


@dataclass(frozen=True, eq=False)
class Found:
    """What is known of the distance from a curve over all times.

    Attributes:
        worst: Largest measured error of position [m] and rotation [rad], shape (2,).
        time: When each was measured, shape (2,) [s].
        unproven: Of each the first interval without proof, if there is one.
    """

    worst: Floats
    time: Floats
    unproven: tuple[tuple[float, float] | None, tuple[float, float] | None]


@check_requirement.register
def _(requirement: FollowsCurve, motion: Motion, when: When) -> tuple[Check, ...]:
    errors = _errors(requirement, motion)
    if when is When.END:
        at = errors.at(np.array((motion.duration,)), np.array((requirement.until,)))[0]
        found = Found(at, np.full(2, motion.duration), (None, None))
    else:
        found = follow(requirement, motion)
    tolerances = (requirement.position_tolerance, requirement.rotation_tolerance)
    judged = range(1 if np.isinf(requirement.rotation_tolerance) else 2)
    return tuple(
        _check(requirement, motion, when, found, which=which, tolerance=tolerances[which]) for which in judged
    )


def _check(
    requirement: FollowsCurve, motion: Motion, when: When, found: Found, *, which: int, tolerance: float
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


def follow(requirement: FollowsCurve, motion: Motion) -> Found:
    """Find a witness of how far along the curve the frame is, and bound its errors at all times."""
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
    return Found(worst, when, (unproven[0], unproven[1]))


def _errors(requirement: FollowsCurve, motion: Motion) -> Errors:
    moving = RelativeMotion(
        motion, requirement.frame, reference=requirement.reference, offset=requirement.offset
    )
    return Errors(requirement, CurvePlaces(requirement.curve), moving.placements)


def _bulge(errors: Errors, moving: RelativeMotion, span: _Span) -> Floats:
    """Bound how far errors rise inside intervals above those at their ends, shape (c, 2)."""
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
    """Cut intervals into equal times, and find where the frame is then, in order, between the ends."""
    part = np.arange(PIECES + 1) / PIECES
    times = span.begin[:, None] + (span.end - span.begin)[:, None] * part
    s = span.first[:, None] + (span.last - span.first)[:, None] * part
    inner = (slice(None), slice(1, -1))
    low, high = (np.repeat(side, PIECES - 1) for side in (span.first, span.last))
    s[inner] = refined(errors, times[inner].ravel(), s[inner].ravel(), low, high).reshape(-1, PIECES - 1)
    s = np.maximum.accumulate(s, axis=1)
    return _Span(times[:, :-1].ravel(), times[:, 1:].ravel(), s[:, :-1].ravel(), s[:, 1:].ravel())


@quantities.register
def _(requirement: FollowsCurve, motion: Motion) -> tuple[Quantity, ...]:
    errors = _errors(requirement, motion)

    curve = errors.curve(errors.candidate_fractions(requirement.until))
    tolerances = np.array((requirement.position_tolerance, errors.chord(requirement.rotation_tolerance)))

    def excess(frame: Floats) -> Floats:
        """How far the tolerances are exceeded at the nearest point of the curve, shape (c,)."""
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
