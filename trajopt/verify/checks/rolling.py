"""Check that the wheels of a differential-drive base roll without sliding sideways.

Without correction, the wheels move the base with the same yaw, but without the velocity s(t) across the
heading. So the base drifts from the plan by e(t), the integral of s from the start: a property of the path
that no timing changes. Over an interval of length h it is bounded by the middle's value times h, with an
error of at most h^3 / 24 times a bound of the second derivative of s.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from trajopt.values.arrays import Floats
from trajopt.values.printed import in_length
from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.kernel.motion import JudgedMotion
from trajopt.verify.specification import Criterion

_FIRST_CUTS = 8
"""Initial intervals per piece of a trajectory; doubled until the result is decisive."""
_MOST_INTERVALS = 200_000

_EXACT = 0.01
"""Accepted error of the reported value, as a share of the bound."""


@dataclass(frozen=True)
class _Straying:
    """Largest drift of a base [m] at ends of intervals, with its error, and further drift within them."""

    measured: float
    error: float
    beside: float
    time: float

    @property
    def most(self) -> float:
        return self.measured + self.error + self.beside

    def decides(self, accepted: float) -> bool:
        kept = self.most <= accepted
        return self.error <= _EXACT * accepted and (kept or self.measured - self.error > accepted)


@dataclass(frozen=True, eq=False)
class RollingCriterion(Criterion):
    """Drift of a differential-drive base from its planned motion; other bases pass without a check."""

    motion: JudgedMotion

    def measure(self) -> Iterator[Check]:
        """Return the drift; intervals are cut until the result is decisive."""
        motion, reduced = self.motion, self.motion.reduced
        base = reduced.scene.robot.base
        if not base.rolls or not set(base.joints) <= set(reduced.joint_names):
            return
        x, y, yaw = (reduced.joint_names.index(joint) for joint in base.joints)
        places = (x, y, yaw)
        cuts, accepted = _FIRST_CUTS, base.drift
        found = _straying(motion, places, cuts)
        while not found.decides(accepted) and 2 * cuts * len(motion.trajectory.times) <= _MOST_INTERVALS:
            cuts *= 2
            found = _straying(motion, places, cuts)
        proven = found.most <= accepted
        evidence = Evidence.PROVEN if proven else Evidence.UNPROVEN
        if found.measured - found.error > accepted:
            evidence = Evidence.SAMPLED
        detail = (
            f"wheels driven as planned carry {base.name} {in_length(found.measured)} away from the planned "
            f"motion, {in_length(accepted)} is accepted"
        )
        if not proven:
            detail += "; more knots reduce the slip"
        yield Check(
            kind=CheckKind.ROLLING,
            name="rolling",
            subject=base.name,
            value=found.measured,
            bound=accepted,
            unit="m",
            time=found.time,
            slack=accepted - found.measured,
            evidence=evidence,
            holds=proven,
            detail=detail,
        )


def _straying(motion: JudgedMotion, places: tuple[int, int, int], cuts: int) -> _Straying:
    times = motion.trajectory.times
    share = np.arange(cuts) / cuts
    begin = (times[:-1, None] + np.diff(times)[:, None] * share).ravel()
    end = np.append(begin[1:], times[-1])
    length, middle = end - begin, (begin + end) / 2.0
    x, y, yaw = places
    heading = motion.trajectory(middle)[:, yaw]
    velocity = motion.trajectory(middle, 1)[:, [x, y]]
    across = np.stack((-np.sin(heading), np.cos(heading)), axis=1)
    slip = np.einsum("ci,ci->c", velocity, across)[:, None] * across
    first, second = _changes(motion, places, begin, end)
    steps = np.concatenate((np.zeros((1, 2)), np.cumsum(slip * length[:, None], axis=0)))
    away = np.linalg.norm(steps, axis=1)
    error = float((second * length**3).sum() / 24.0)
    # Between its ends an interval differs from the nearer one by at most half its length times its speed.
    beside = (np.linalg.norm(slip, axis=1) + first * length / 2.0) * length / 2.0
    at = int(away.argmax())
    return _Straying(float(away[at]), error, float(beside.max()), float(np.append(begin, times[-1])[at]))


def _changes(
    motion: JudgedMotion, places: tuple[int, int, int], begin: Floats, end: Floats
) -> tuple[Floats, Floats]:
    """Bound the first and second derivative of the velocity across the heading over intervals, (c,) each.

    It is P v with P = n n', n across the heading: |P'| is the yaw rate w, |P''| at most |w'| + 2 w^2.
    """
    x, y, yaw = places
    low, high = zip(*(motion.group[order].range(begin, end) for order in (1, 2, 3)), strict=True)
    size = [np.maximum(high[order], -low[order]) for order in range(3)]
    speed, bend, jerk = (np.hypot(each[:, x], each[:, y]) for each in size)
    turn, turning = size[0][:, yaw], size[1][:, yaw]
    return turn * speed + bend, (turning + 2.0 * turn**2) * speed + 2.0 * turn * bend + jerk
