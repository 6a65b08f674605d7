"""Options of a supervisor, and the check of time stamps against the clock of the executor."""

from dataclasses import dataclass, field

from trajopt.planning import Budget
from trajopt.values.arrays import not_negative, number, positive
from trajopt.values.errors import ClockError
from trajopt.values.errors.arguments import checked

CLOCK_TOLERANCE = 0.01
"""Largest difference of synchronised clocks of a robot's computers [s]: NTP in one network keeps it."""


def on_clock(stamp: float | None, now: float, tolerance: float) -> float:
    """Return a time stamp that is not ahead of the executor's clock [s]; now when None."""
    if stamp is None:
        return now
    ahead = number("stamp", stamp) - now
    if ahead > tolerance:
        raise ClockError(
            f"stamp {stamp:.3f} s is {ahead:.3f} s ahead of the executor's clock, which shows {now:.3f} s; "
            f"clock_tolerance is {tolerance:g} s; "
            "correct the clock of the sender, or stamp by executor.now()"
        )
    return min(stamp, now)


@checked
@dataclass(frozen=True, kw_only=True)
class SupervisorOptions:
    """Options of a supervisor.

    Attributes:
        ahead: Time for which the robot is committed to its motion before it would brake [s]. A plan that
            takes no longer changes the motion without a stop.
        on_the_way: Whether to plan while the robot moves, or only when it is at rest.
        retry: Time from a failed plan to the next [s].
        patience: If a dynamic obstacle blocks the rest of the motion, the path is driven slower or with a
            stop if this ends at most this much later [s]; otherwise the motion is replanned. With 0 it is
            always replanned.
        clock_tolerance: Stamps ahead of the clock by up to this count as now [s].
    """

    cycle: float = 0.02
    ahead: float = 0.1
    budget: Budget = field(default_factory=Budget)
    on_the_way: bool = True
    retry: float = 0.25
    patience: float = 1.0
    clock_tolerance: float = CLOCK_TOLERANCE

    def __post_init__(self) -> None:
        for name in ("cycle", "ahead", "retry"):
            positive(name, getattr(self, name))
        for name in ("patience", "clock_tolerance"):
            not_negative(name, getattr(self, name))
