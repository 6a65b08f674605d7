"""Meter: what planning has used so far, held against its budget."""

import time
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from threading import Event
from time import monotonic

from trajopt.planning.budget import Budget, Stop
from trajopt.query import Counts
from trajopt.solvers import Iteration

WORK = "forward_kinematics"
"""The count that a budget's work bounds."""

Progress = Callable[[str, Iteration | None], None]
"""Called with the stage, and with the solver's step while it works."""


class Stopped(Exception):
    """The budget is used up, or planning was cancelled; raised between pieces of work."""

    def __init__(self, stop: Stop) -> None:
        """Note what it was."""
        self.stop = stop
        super().__init__(stop.value)


@dataclass(eq=False)
class Meter:
    """Counts work and time of one call of planning, and raises `Stopped` when there is to be no more.

    Attributes:
        budget: What may be used.
        cancel: Once set, from any thread, planning stops.
        progress: Called at every stage and step.
        counts: Exact numbers of the work.
        seconds: Process time of each stage [s].
    """

    budget: Budget
    cancel: Event | None = None
    progress: Progress | None = None
    counts: dict[str, int] = field(default_factory=dict[str, int])
    seconds: dict[str, float] = field(default_factory=dict[str, float])
    _before: int = 0
    _begin: float = 0.0
    _wall_begin: float = 0.0

    def __post_init__(self) -> None:
        """Start the clocks."""
        self._begin, self._wall_begin = self.budget.clock(), monotonic()

    @property
    def work(self) -> int:
        """Configurations looked at so far."""
        return self._before + self.counts.get(WORK, 0)

    def check(self, counts: Counts | None = None) -> None:
        """Raise `Stopped` if the budget is used up.

        Args:
            counts: Work that goes on and is not yet counted.
        """
        budget = self.budget
        going_on = 0 if counts is None else counts.forward_kinematics
        if self.cancel is not None and self.cancel.is_set():
            raise Stopped(Stop.CANCEL)
        if budget.work is not None and self.work + going_on > budget.work:
            raise Stopped(Stop.WORK)
        if budget.seconds is not None and self.used >= budget.seconds:
            raise Stopped(Stop.CLOCK)
        wall = budget.wall_seconds
        if wall is not None and monotonic() - self._wall_begin >= wall:
            raise Stopped(Stop.CLOCK)

    @property
    def used(self) -> float:
        """Time since planning began, by the budget's clock [s]."""
        return self.budget.clock() - self._begin

    def step(self, iteration: Iteration, counts: Counts) -> None:
        """Show a step of the solver and check the budget."""
        if self.progress is not None:
            self.progress("optimise", iteration)
        self.check(counts)

    def count(self, **numbers: int) -> None:
        """Add to the counts."""
        self.add(numbers, {})

    def count_work(self, counts: Counts) -> None:
        """Add what a query has counted."""
        self.count(
            distance_calls=counts.distances,
            bounds=counts.bounds,
            forward_kinematics=counts.forward_kinematics,
        )

    def add(self, counts: Mapping[str, int], seconds: Mapping[str, float]) -> None:
        """Add the work of another process."""
        for name, number in counts.items():
            self.counts[name] = self.counts.get(name, 0) + number
        for name, used in seconds.items():
            self.seconds[name] = self.seconds.get(name, 0.0) + used

    @contextmanager
    def stage(self, name: str) -> Generator[None]:
        """Check the budget, say that a stage begins, and take the time until its end."""
        self.check()
        if self.progress is not None:
            self.progress(name, None)
        begin = time.process_time()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.process_time() - begin

    @property
    def so_far(self) -> tuple[int, float, float]:
        """What another process has to know: the work done, the time used by budget's and wall's clock [s]."""
        return self.work, self.used, monotonic() - self._wall_begin

    @staticmethod
    def elsewhere(budget: Budget, so_far: tuple[int, float, float]) -> "Meter":
        """Return a meter for another process: nothing counted yet, as much used up as there.

        Args:
            budget: What may be used.
            so_far: What was used when the process was sent for; its own clocks may begin anew.
        """
        other = Meter(budget)
        other._before, used, wall = so_far
        other._begin, other._wall_begin = budget.clock() - used, monotonic() - wall
        return other
