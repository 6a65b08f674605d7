"""Options of a supervisor, and the check of time stamps against the clock of the executor."""

from dataclasses import dataclass, field

from trajopt.planning import Budget
from trajopt.values.arrays import number
from trajopt.values.errors import ClockError, ProblemError
from trajopt.values.errors.arguments import checked

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


@checked
@dataclass(frozen=True, kw_only=True)
class SupervisorOptions:
    """Options of a supervisor.

    Attributes:
        cycle: Time from one cycle to the next [s].
        ahead: So far ahead of now the robot is committed to its motion before it would brake [s]. A plan that
            takes no longer than that changes the motion without a stop; the longer, the later a stop begins.
        budget: What each plan may take.
        on_the_way: Whether it plans while the robot moves, or only once it stands.
        retry: After a plan that failed the next is tried so much later [s].
        patience: Where something that moves breaks the rest of the motion, the same path is driven slower, or
            with a stop, if that ends at most so much later [s]; else it is planned anew. With 0 it always is.
        clock_tolerance: A stamp ahead of the executor's clock by at most so much counts as now [s]; one that
            is farther ahead is refused.
    """

    cycle: float = 0.02
    ahead: float = 0.1
    budget: Budget = field(default_factory=Budget)
    on_the_way: bool = True
    retry: float = 0.25
    patience: float = 1.0
    clock_tolerance: float = CLOCK_TOLERANCE

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ProblemError: If one is not positive, or the patience or the clock tolerance is negative.
        """
        for name in ("cycle", "ahead", "retry"):
            if not number(name, getattr(self, name)) > 0.0:
                raise ProblemError(f"{name} must be positive, is {getattr(self, name):g}")
        for name in ("patience", "clock_tolerance"):
            if number(name, getattr(self, name)) < 0.0:
                raise ProblemError(f"{name} must not be negative, is {getattr(self, name):g}")
