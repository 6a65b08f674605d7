"""Check of `ToolSpeed`, proven at all times by bounds on derivatives of the velocity.

Over an interval of length h the velocity is within h / 2 of its middle's times a bound of its first
derivative, and within h^2 / 8 times a bound of its second derivative of the chord between its ends, on
which no velocity is larger than at one of the ends.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from trajopt.problem.tool_speed import ToolSpeed
from trajopt.values.arrays import Floats, Ints
from trajopt.values.printed import in_length
from trajopt.values.trajectory import Interpolation
from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.checks.quantities import Component, When, requirement_check
from trajopt.verify.kernel.interval_proof import Excess, prove_over_time
from trajopt.verify.kernel.motion import JudgedMotion
from trajopt.verify.kernel.relative_motion import PointMotion
from trajopt.verify.specification import Criterion

SAMPLES = 2001
"""Number of times at which the ramps of a steady speed are searched."""
STEADY_SHARE = 0.5
"""Share of the path that a steady speed must cover, so that it is more than two ramps."""
DROPS = np.arange(0.001, 0.031, 0.001)
"""Drops of a speed below its limit that a timing may leave, as it runs evenly slower where one peak would be
too fast.
"""
TINY = 1e-12
"""Smallest speed with a direction [m/s]."""
KINDS = (("tool speed", "m/s"), ("tool turning", "rad/s"))


@dataclass(frozen=True, eq=False)
class ToolSpeedCriterion(Criterion):
    """Speed limits of one tool."""

    motion: JudgedMotion
    limited: ToolSpeed

    def measure(self) -> Iterator[Check]:
        motion, limited = self.motion, self.limited
        moving = PointMotion(motion, limited.frame, offset=limited.offset)
        for which, limit in enumerate((limited.linear, limited.angular)):
            if np.isfinite(limit):
                yield _check(motion, moving, limited, which=which)
        if np.isfinite(limited.steady):
            yield _steadiness(motion, moving, limited)


def _steadiness(motion: JudgedMotion, moving: PointMotion, limited: ToolSpeed) -> Check:
    floor = (1.0 - limited.steady) * limited.linear
    times = np.linspace(0.0, motion.trajectory.duration, SAMPLES)
    velocities = moving.speeds(times)[0]
    speeds = np.linalg.norm(velocities, axis=1)
    steady = np.flatnonzero(speeds >= floor)
    when, share, evidence = float(times[speeds.argmax()]), 0.0, Evidence.SAMPLED
    if len(steady):
        between = slice(int(steady[0]), int(steady[-1]) + 1)
        when = float(times[between][speeds[between].argmin()])
        share = float(speeds[between].sum() / speeds.sum())
        slow = _slowness(motion, moving, floor, float(times[between][0]), float(times[between][-1]))
        proof = prove_over_time(motion, slow)
        evidence = Evidence.PROVEN if proof.evidence is Evidence.PROVEN else Evidence.SAMPLED
        when = proof.time if proof.evidence is Evidence.SAMPLED else when
    value, remedy = float(np.linalg.norm(moving.speeds(np.array((when,)))[0])), ""
    drop = _least_drop(speeds, limited)
    if (share < STEADY_SHARE or value < floor) and drop is not None:
        remedy = f"; a timing keeps the speed within {drop:.1%}: allow this drop (`steady={drop:.3g}`)"
    elif share < STEADY_SHARE:
        remedy = _remedy(speeds, steady, float(times[1]))
    elif value < floor:
        before, after = (
            velocities[steady[times[steady] <= when][-1]],
            velocities[steady[times[steady] >= when][0]],
        )
        remedy = _rounder(when, before, after)
    return Check(
        kind=CheckKind.TOOL_SPEED,
        name=f"{When.ALWAYS.value}: steady speed",
        subject=limited.frame,
        value=value,
        bound=floor,
        unit="m/s",
        time=when,
        slack=value - floor,
        evidence=evidence,
        holds=value >= floor and share >= STEADY_SHARE,
        detail=f"at least {value:.4g} m/s over {share:.0%} of the way, {floor:.4g} m/s are required{remedy}",
    )


def _least_drop(speeds: Floats, limited: ToolSpeed) -> float | None:
    """Return the next larger drop that suffices, if it is that of a timing rather than of ramps or bends.

    Args:
        speeds: At equal steps of time, shape (s,) [m/s].
    """
    for drop in DROPS[limited.steady < DROPS].tolist():
        enough = np.flatnonzero(speeds >= (1.0 - drop) * limited.linear)
        if len(enough):
            between = speeds[enough[0] : enough[-1] + 1]
            if len(between) == len(enough) and between.sum() >= STEADY_SHARE * speeds.sum():
                return drop
    return None


def _remedy(speeds: Floats, steady: Ints, step: float) -> str:
    """Return how to make a speed steady that is no more than two ramps.

    Args:
        speeds: At equal steps of time [s], shape (s,) [m/s].
        steady: Indices of those that are high enough.
    """
    if not len(steady):
        return f"; at most {float(speeds.max()):.4g} m/s are reached: lower the speed, or lengthen the way"
    ramps = (in_length(step * float(part.sum())) for part in (speeds[: steady[0]], speeds[steady[-1] + 1 :]))
    return (
        f"; its ramps take {' and '.join(ramps)}: lengthen the way by as much at its ends, or lower the speed"
    )


def _rounder(when: float, before: Floats, after: Floats) -> str:
    """Return how to avoid a part that is too slow.

    Args:
        before: Last velocity before it that is high enough, shape (3,) [m/s].
        after: First one after it, shape (3,) [m/s].
    """
    share = before @ after / (np.linalg.norm(before) * np.linalg.norm(after))
    turned = np.degrees(np.arccos(np.clip(share, -1.0, 1.0)))
    if turned < 1.0:
        return f"; it is slowest at {when:.2f} s: lower the speed"
    return (
        f"; it is slowest at {when:.2f} s, where the way turns by {turned:.0f} deg: round it with a larger "
        "radius (`blend` of a polyline), or lower the speed"
    )


def _slowness(
    motion: JudgedMotion, moving: PointMotion, floor: float, since: float, until: float
) -> Callable[[Floats, Floats], Excess]:
    """Return the excess of a least speed over the speed between two times; elsewhere it is negative.

    Along the direction of the middle velocity, a velocity is at least the smaller one of the ends less its
    distance from the chord.
    """
    smooth = motion.trajectory.interpolation is Interpolation.QUINTIC

    def excess(begin: Floats, end: Floats) -> Excess:
        begin, end = np.clip(begin, since, until), np.clip(end, since, until)
        middle, length = (begin + end) / 2, end - begin
        times = np.stack((begin, middle, end))
        velocities = moving.speeds(times.ravel())[0].reshape(*times.shape, 3)
        speeds, changes = np.linalg.norm(velocities, axis=2), moving.changes(begin, end)
        least = speeds[1] - changes.first[:, 0] * length / 2
        if smooth:
            along = np.einsum(
                "ecx,cx->ec", velocities[::2], velocities[1] / np.maximum(speeds[1], TINY)[:, None]
            )
            least = np.maximum(least, along.min(axis=0) - changes.second[:, 0] * length**2 / 8)
        slowest, rows = speeds.argmin(axis=0), np.arange(len(begin))
        inside = length > 0.0
        measured = np.where(inside, floor - speeds[slowest, rows], -np.inf)
        return Excess(measured, times[slowest, rows], np.where(inside, floor - least, -np.inf))

    return excess


def _check(motion: JudgedMotion, moving: PointMotion, limited: ToolSpeed, *, which: int) -> Check:
    limit = (limited.linear, limited.angular)[which]
    smooth = motion.trajectory.interpolation is Interpolation.QUINTIC

    def speed(times: Floats) -> Floats:
        return np.linalg.norm(moving.speeds(times)[which], axis=1)

    def excess(begin: Floats, end: Floats) -> Excess:
        middle, length = (begin + end) / 2, end - begin
        changes = moving.changes(begin, end)
        if not smooth:  # the velocity at an end may be that of the next segment
            reached = speed(middle)
            return Excess(reached - limit, middle, reached + changes.first[:, which] * length / 2 - limit)
        times = np.stack((begin, middle, end))
        speeds = speed(times.ravel()).reshape(times.shape)
        chord = np.maximum(speeds[0], speeds[2]) + changes.second[:, which] * length**2 / 8
        bound = np.minimum(chord, speeds[1] + changes.first[:, which] * length / 2)
        worst, rows = speeds.argmax(axis=0), np.arange(len(begin))
        return Excess(speeds[worst, rows] - limit, times[worst, rows], bound - limit)

    proof = prove_over_time(motion, excess)
    kind, unit = KINDS[which]
    value = float(speed(np.array((proof.time,)))[0])
    component = Component(kind, value, limit)
    return requirement_check(
        When.ALWAYS, kind=kind, subject=limited.frame, unit=unit, component=component, proof=proof
    )
