"""Budget: how much work planning may do, for how long, on how many cores; and what stopped it."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from multiprocessing.context import BaseContext

from trajopt.arrays import number, one_of
from trajopt.errors import ProblemError, shown

BACKSTOP = (10.0, 10.0)
"""A budget by another clock than the wall's also ends after so many times its seconds, and so many more, on
the wall's: a sleep costs no processor time, and a clock that stands still would never end it."""


class Stop(Enum):
    """What ended planning before it was done."""

    CLOCK = "the time was used up; on another day the answer may differ"
    WORK = "the counted work was used up"
    CANCEL = "it was cancelled"


@dataclass(frozen=True)
class Budget:
    """What planning may use.

    With none of `seconds`, `work` and `tries` it ends when the first guesses that it knows of are
    tried; with any of them it goes on to others until that is used up.

    Attributes:
        seconds: Time by `clock` [s]. The answer then depends on the machine.
        work: Configurations that goal search, optimiser and sampling planner may look at: an exact
            number, with which the same question has the same answer everywhere.
        tries: First guesses at most; 1 is the straight line to the nearest goal configuration alone.
        workers: Processes that try first guesses, from when the straight line has failed (with
            `improve`: has been tried). The answer is the same for any number.
        improve: Whether to go on after the first motion, until the budget is used up, and return the
            shortest in time.
        clock: What tells the time [s]: the wall's; `time.process_time` for benchmarks. By any other clock
            than the wall's planning ends after `wall_seconds` too.
        processes: What starts workers, such as `multiprocessing.get_context("spawn")`; when None, what Python
            starts processes by, but no fork where there are several threads. Workers that are not forked
            take a second to begin, are sent problem, method and clock by pickle, and in a script need
            `if __name__ == "__main__":`.
    """

    seconds: float | None = None
    work: int | None = None
    tries: int | None = None
    workers: int = 1
    improve: bool = False
    clock: Callable[[], float] = time.monotonic
    processes: BaseContext | None = None

    def __post_init__(self) -> None:
        """Refuse what bounds nothing.

        Raises:
            ProblemError: If a number is not positive, or nothing would ever end the improvement.
            ShapeError: If the seconds are no number.
        """
        if self.seconds is not None and number("seconds", self.seconds, infinite=True) <= 0.0:
            raise ProblemError(f"a budget's seconds must be above zero, are {self.seconds}")
        bounds = {"work": self.work, "tries": self.tries}
        given = {name: value for name, value in bounds.items() if value is not None}
        for name, value in (given | {"workers": self.workers}).items():
            if type(value) is not int or value < 1:
                raise ProblemError(f"a budget's {name} must be a whole number above zero, is {shown(value)}")
        one_of("improve", self.improve, bool)
        if not callable(self.clock):
            raise ProblemError(f"clock is a function that tells the time, is {shown(self.clock)}")
        if self.improve and not self.bounded:
            raise ProblemError("a budget that improves needs seconds, work or tries to end it")
        if self.processes is not None:
            one_of("processes", self.processes, BaseContext)

    @property
    def wall_seconds(self) -> float | None:
        """When planning ends whatever `clock` says: 10 s after ten times the seconds; None without [s]."""
        if self.seconds is None or self.clock is time.monotonic:
            return self.seconds
        return BACKSTOP[0] * self.seconds + BACKSTOP[1]

    @property
    def bounded(self) -> bool:
        """Whether anything but running out of first guesses ends planning."""
        return any(bound is not None for bound in (self.seconds, self.work, self.tries))
