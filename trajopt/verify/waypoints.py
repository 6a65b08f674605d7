"""The judge's check of waypoints: that a motion passes each within its tolerances, in order.

One moment at which all of a waypoint holds is a proof. Moments are looked for on a grid and, where what is
missing has a minimum on it, more finely around that.
"""

from collections.abc import Callable, Sequence

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.requirements import Requirement
from trajopt.verify.certificate import Check, Evidence
from trajopt.verify.motion import Motion
from trajopt.verify.quantities import quantities
from trajopt.verify.quantity import Quantity, sampled_times

_ZOOMS = 8
_PIECES = 16


def waypoint_checks(motion: Motion, waypoints: Sequence[Sequence[Requirement]]) -> tuple[Check, ...]:
    """Judge that each waypoint holds at some moment not before that of the one before it.

    Args:
        motion: The motion.
        waypoints: What must hold at each, in order.

    Raises:
        ProblemError: If a requirement has no check.
        NameNotFound: If a requirement names what does not exist.
    """
    checks: list[Check] = []
    earliest = 0.0
    for number, wanted in enumerate(waypoints, start=1):
        numbers = [item for requirement in wanted for item in quantities(requirement, motion)]
        if not numbers:  # a line of sight past nothing holds at any moment
            continue
        found = _check(motion, f"waypoint {number}", numbers, earliest)
        if found.holds and found.time is not None:
            earliest = found.time
        checks.append(found)
    return tuple(checks)


def _check(motion: Motion, name: str, numbers: Sequence[Quantity], earliest: float) -> Check:
    def excesses(times: Floats) -> Floats:
        return np.array([item.excess(item.states(times)) for item in numbers])

    time = _passage(motion, lambda times: excesses(times).max(axis=0), earliest)
    now = np.array((time,))
    over = excesses(now)[:, 0]
    tightest = numbers[int(over.argmax())]
    excess = float(over.max())
    holds = excess <= motion.options.excess
    missed = f"the nearest moment from {earliest:.3f} s on is {time:.3f} s"
    missed += f", and misses {tightest.name} by {excess:.4g} {tightest.unit}".rstrip()
    return Check(
        name=f"{name}: {tightest.kind}",
        subject=tightest.subject,
        value=float(tightest.number(tightest.states(now))[0]),
        bound=tightest.limit,
        unit=tightest.unit,
        time=time,
        slack=-excess,
        evidence=Evidence.PROVEN if holds else Evidence.SAMPLED,
        holds=holds,
        detail=f"passed at {time:.3f} s" if holds else missed,
    )


def _passage(motion: Motion, excess: Callable[[Floats], Floats], earliest: float) -> float:
    """Return the first moment found from `earliest` on at which the excess is accepted, or the nearest."""
    times = sampled_times(motion)
    times = np.concatenate(([earliest], times[times > earliest]))
    values = excess(times)
    accepted = motion.options.excess
    padded = np.concatenate(([np.inf], values, [np.inf]))
    lowest = (values <= padded[:-2]) & (values <= padded[2:])
    nearest, when = float(values[0]), earliest
    for place in np.flatnonzero(lowest | (values <= accepted)).tolist():
        begin, end = times[max(place - 1, 0)], times[min(place + 1, len(times) - 1)]
        value, time = _zoom(excess, float(begin), float(end), accepted)
        if value < nearest:
            nearest, when = value, time
        if nearest <= accepted:
            break
    return when


def _zoom(
    excess: Callable[[Floats], Floats], begin: float, end: float, accepted: float
) -> tuple[float, float]:
    """Return the excess and the time of the first accepted or the lowest sample, ever more finely."""
    low, high = begin, end
    best, when = np.inf, begin
    for _ in range(_ZOOMS):
        times = np.linspace(low, high, _PIECES + 1)
        values = excess(times)
        held = np.flatnonzero(values <= accepted)
        place = int(held[0]) if len(held) else int(values.argmin())
        best, when = float(values[place]), float(times[place])
        if held.size and place == 0:
            break
        # The entry lies before the first moment that holds; a minimum on either side.
        low = float(times[max(place - 1, 0)])
        high = when if held.size else float(times[min(place + 1, _PIECES)])
    return best, when
