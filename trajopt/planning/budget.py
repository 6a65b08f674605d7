"""Budget of planning: work, time and cores allowed, and the use of them."""

import time
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, replace
from enum import Enum
from threading import Event
from time import monotonic

from trajopt.geometry import WorkCounts
from trajopt.optimise.solvers import Iteration
from trajopt.values.arrays import function, number, one_of, unless_none
from trajopt.values.errors import ProblemError, shown

BACKSTOP = (10.0, 10.0)
"""Factor and offset of the wall-time limit of a budget by another clock: a sleep costs no processor time."""


class Stop(Enum):
    """Reason for ending planning early."""

    CLOCK = "the time was used up; another run may end differently"
    WORK = "the counted work was used up"
    CANCEL = "it was cancelled"


@dataclass(frozen=True)
class Budget:
    """Limits of planning.

    Without `seconds`, `work` and `attempts` planning ends with the seeds of the schedule; with any of them it
    goes on to other seeds until that limit.

    Attributes:
        seconds: Time by `clock` [s]. The answer then depends on the machine.
        work: Most configurations to evaluate; the answer is then the same everywhere.
        attempts: Most seeds; 1 is the straight line to the nearest goal configuration alone.
        workers: Threads that attempt seeds, once the straight line has failed (with `improve`: has been
            attempted). The answer is the same for any number.
        improve: Whether to use up the budget and return the fastest motion.
        clock: Returns the time [s]: wall time; `time.process_time` for benchmarks. With any other clock
            planning also ends after `wall_seconds`.
    """

    seconds: float | None = None
    work: int | None = None
    attempts: int | None = None
    workers: int = 1
    improve: bool = False
    clock: Callable[[], float] = time.monotonic

    def __repr__(self) -> str:
        changed = (item for item in fields(self) if getattr(self, item.name) != item.default)
        return f"Budget({', '.join(f'{item.name}={shown(getattr(self, item.name))}' for item in changed)})"

    def __post_init__(self) -> None:
        if self.seconds is not None and number("seconds", self.seconds, infinite=True) <= 0.0:
            raise ProblemError(f"budget: seconds must be positive, is {self.seconds:g}")
        bounds = {"work": self.work, "attempts": self.attempts}
        given = {name: value for name, value in bounds.items() if value is not None}
        for name, value in (given | {"workers": self.workers}).items():
            if type(value) is not int or value < 1:
                raise ProblemError(f"budget: {name} must be a positive whole number, is {shown(value)}")
        one_of("improve", self.improve, bool)
        if not callable(self.clock):
            raise ProblemError(f"clock must be a function that returns the time [s], is {shown(self.clock)}")
        if self.improve and not self.bounded:
            raise ProblemError("a budget that improves needs seconds, work or attempts to end it")

    @property
    def wall_seconds(self) -> float | None:
        """Wall-time limit [s] for any `clock`: 10 s after ten times the seconds, if given."""
        if self.seconds is None or self.clock is time.monotonic:
            return self.seconds
        return BACKSTOP[0] * self.seconds + BACKSTOP[1]

    @property
    def bounded(self) -> bool:
        """Whether anything else than running out of seeds ends planning."""
        return any(bound is not None for bound in (self.seconds, self.work, self.attempts))


WORK = "forward_kinematics"
"""The count that a budget's work bounds."""

Progress = Callable[[str, Iteration | None], None]
"""Called with the stage, and with the solver's step while it works."""


class Stopped(Exception):
    """The budget is used up, or planning was cancelled; raised between pieces of work."""

    def __init__(self, stop: Stop) -> None:
        self.stop = stop
        super().__init__(stop.value)


@dataclass(eq=False)
class BudgetTracker:
    """Counts work and time of one call of planning; raises `Stopped` at a limit.

    Attributes:
        seconds: CPU time of the thread in each stage [s].
    """

    budget: Budget
    cancel: Event | None = None
    progress: Progress | None = None
    counts: dict[str, int] = field(default_factory=dict[str, int])
    seconds: dict[str, float] = field(default_factory=dict[str, float])
    _before: int = 0
    _begin: float = 0.0
    _wall_begin: float = 0.0
    _inside: float = 0.0

    def __post_init__(self) -> None:
        """Check the arguments and start the clocks.

        Raises:
            ProblemError: If `cancel` is not an event, or `progress` cannot be called.
        """
        unless_none("cancel", self.cancel, Event)
        function("progress", self.progress)
        self._begin, self._wall_begin = self.budget.clock(), monotonic()

    @property
    def work(self) -> int:
        """Configurations evaluated so far."""
        return self._before + self.counts.get(WORK, 0)

    def check(self, counts: WorkCounts | None = None) -> None:
        """Raise `Stopped` if the budget is used up; `counts` is work in progress that is not yet counted."""
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

    def remaining(self) -> Budget:
        """Return the rest of the budget, for a call of planning inside this one.

        Raises:
            Stopped: If nothing is left.
        """
        self.check()
        budget, seconds, work = self.budget, self.budget.seconds, self.budget.work
        if seconds is not None:
            seconds -= self.used
            if seconds <= 0.0:
                raise Stopped(Stop.CLOCK)
        if work is not None:
            work -= self.work
            if work < 1:
                raise Stopped(Stop.WORK)
        return replace(budget, seconds=seconds, work=work)

    @contextmanager
    def optimising(self, counts: WorkCounts) -> Generator["StepWatch"]:
        """Count and bound the work of a solver; yields a function to call after every step.

        Args:
            counts: Of the program that it solves; increases from now on are its work.
        """
        watch = StepWatch(self, counts, replace(counts))
        with self.stage("optimise"):
            try:
                yield watch
            finally:
                self.count_work(counts.since(watch.before))

    def count(self, **numbers: int) -> None:
        """Add to the counts."""
        self.add(numbers, {})

    def count_work(self, counts: WorkCounts) -> None:
        """Add the counts of a query."""
        self.count(
            distance_calls=counts.distances,
            bounds=counts.bounds,
            forward_kinematics=counts.forward_kinematics,
        )

    def add(self, counts: Mapping[str, int], seconds: Mapping[str, float]) -> None:
        for name, more in counts.items():
            self.counts[name] = self.counts.get(name, 0) + more
        for name, used in seconds.items():
            self.seconds[name] = self.seconds.get(name, 0.0) + used

    @contextmanager
    def stage(self, name: str) -> Generator[None]:
        """Check the budget, report the start of a stage, and measure its time without nested stages."""
        self.check()
        if self.progress is not None:
            self.progress(name, None)
        begin, inside, self._inside = time.thread_time(), self._inside, 0.0
        try:
            yield
        finally:
            used = time.thread_time() - begin
            self.seconds[name] = self.seconds.get(name, 0.0) + used - self._inside
            self._inside = inside + used

    @property
    def so_far(self) -> tuple[int, float, float]:
        """State for another thread: the work done, the time used by the budget's and the wall's clock [s]."""
        return self.work, self.used, monotonic() - self._wall_begin

    @staticmethod
    def elsewhere(budget: Budget, so_far: tuple[int, float, float], over: Event) -> "BudgetTracker":
        """Return a tracker for another thread: nothing counted yet, the same part of the budget used up.

        Args:
            so_far: Use of the budget when the thread was requested.
        """
        other = BudgetTracker(budget, over)
        other._before, used, wall = so_far
        other._begin, other._wall_begin = budget.clock() - used, monotonic() - wall
        return other


@dataclass(frozen=True, eq=False)
class StepWatch:
    """Called by a solver after its steps, perhaps delayed without a listener; raises `Stopped` at a limit."""

    tracker: BudgetTracker
    counts: WorkCounts
    before: WorkCounts

    @property
    def patience(self) -> int | None:
        tracker = self.tracker
        if tracker.progress is not None:
            return 0
        work = tracker.budget.work
        return (
            None if work is None else work - tracker.work - self.counts.since(self.before).forward_kinematics
        )

    def __call__(self, iteration: Iteration, /) -> None:
        if self.tracker.progress is not None:
            self.tracker.progress("optimise", iteration)
        self.tracker.check(self.counts.since(self.before))


DOING: Mapping[str, str] = {
    "examine": "checking the start",
    "seed": "searching goal configurations",
    "optimise": "optimising",
    "retime": "timing",
    "verify": "judging",
    "simulate": "simulating",
    "render": "rendering",
}
"""The name of each stage while it runs."""
