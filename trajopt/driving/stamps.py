"""Stamps: times that others state on the executor's clock."""

from trajopt.values.arrays import number
from trajopt.values.errors import ClockError

CLOCK_TOLERANCE = 0.01
"""Clocks of a robot's computers that are kept in step differ by less [s]: NTP in one network does it."""


def on_clock(stamp: float | None, now: float, tolerance: float) -> float:
    """Return a stamp that is not ahead of the executor's clock [s].

    Args:
        stamp: When something was measured or commanded [s]; now when None.
        now: The time on the executor's clock [s].
        tolerance: A stamp that is ahead by at most so much counts as now [s].

    Raises:
        ClockError: If it is farther ahead.
        ShapeError: If it is not a finite number.
    """
    if stamp is None:
        return now
    ahead = number("stamp", stamp) - now
    if ahead > tolerance:
        raise ClockError(
            f"stamp is {stamp:.3f} s, {ahead:.3f} s ahead of the executor's clock, which shows {now:.3f} s; "
            f"{tolerance:g} s are allowed (clock_tolerance): "
            "correct the clock of the sender, or stamp by executor.now()"
        )
    return min(stamp, now)
