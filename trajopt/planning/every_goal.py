"""Every goal of a set, planned to by itself, so that the motions can be compared."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import inf

import numpy as np

from trajopt.optimise.methods import Choice
from trajopt.planning.budget import Budget, BudgetTracker, Stop, Stopped
from trajopt.planning.result import Result
from trajopt.planning.search import ENDED, PlanSearch, failure_of_all
from trajopt.planning.workspace import PlanningWorkspace
from trajopt.problem.problem import Problem
from trajopt.values.errors import ProblemError


@dataclass(eq=False)
class EveryGoal:
    """One call of planning that keeps the result of every goal.

    Attributes:
        problem: The problem; its goal is a set.
        choice: The method, and the reason for its choice.
        rng: Random generator for each goal; None for the same as when planned alone.
        tracker: Counts the use of the budget, and stops planning.
        on_incumbent: Called with each verified motion that is better than the one before, to any goal.
        results: Of the goals that were planned to, by name.
    """

    problem: Problem
    choice: Choice
    rng: np.random.Generator | None
    tracker: BudgetTracker
    on_incumbent: Callable[[Result], None] | None = None
    results: dict[str, Result] = field(default_factory=dict[str, Result])

    def __post_init__(self) -> None:
        """Refuse a single goal.

        Raises:
            ProblemError: If the goal is not a set.
        """
        if not self.problem.alternatives:
            raise ProblemError("every_goal compares the goals of a set: make one with any_of({name: goal})")

    def planned(self, run: Callable[[PlanSearch], Result]) -> Result:
        """Plan to each goal; return the fastest motion with the results of all.

        Seconds and work are shared out: each goal gets an equal part of the rest, and unused parts go
        to the following goals. Attempts hold for each goal.

        Args:
            run: Runs a search to its end.
        """
        goals, interrupted = self.problem.alternatives, False
        for number, (name, alone) in enumerate(goals.items()):
            try:
                if interrupted:
                    raise Stopped(Stop.CANCEL)
                result = self._of(name, alone, len(goals) - number, run)
            except Stopped as ended:
                result = self._unplanned(alone, ended.stop)
            except KeyboardInterrupt:
                if not any(found.verified for found in self.results.values()):
                    raise
                result = self._unplanned(alone, Stop.CANCEL)
            interrupted = result.stopped is Stop.CANCEL
            self.results[name] = replace(result, goal_name=name)
        best_first = dict(sorted(self.results.items(), key=lambda item: item[1].cost))
        found = next(iter(best_first.values()))
        if not found.verified:
            found = failure_of_all(self.problem, found, best_first)
        return replace(
            found,
            of_each_goal=best_first,
            counts=dict(self.tracker.counts),
            cpu_seconds=dict(self.tracker.seconds),
        )

    def _of(self, name: str, alone: Problem, left: int, run: Callable[[PlanSearch], Result]) -> Result:
        """Plan to one goal with its part of the budget.

        Raises:
            Stopped: If nothing of it is left.
        """
        rng = np.random.default_rng(0) if self.rng is None else self.rng.spawn(1)[0]
        part = BudgetTracker(
            shared(self.tracker.remaining(), left), self.tracker.cancel, self.tracker.progress
        )
        result = run(PlanSearch(alone, self.choice, rng, part, self._better(name)))
        self.tracker.add(part.counts, part.seconds)
        return result

    def _unplanned(self, alone: Problem, stop: Stop) -> Result:
        result = PlanningWorkspace(alone, self.tracker).result(ENDED[stop], "nothing was attempted")
        return replace(result, stopped=stop)

    def _better(self, name: str) -> Callable[[Result], None] | None:
        """Return the callback for motions to a goal: it reports those better than motions to other goals."""
        told = self.on_incumbent
        if told is None:
            return None
        best = min((result.cost for result in self.results.values()), default=inf)
        return lambda found: told(replace(found, goal_name=name)) if found.cost < best else None


def shared(budget: Budget, parts: int) -> Budget:
    """Return an equal part of a budget's seconds and work."""
    seconds, work = budget.seconds, budget.work
    return replace(
        budget,
        seconds=None if seconds is None else seconds / parts,
        work=None if work is None else max(1, work // parts),
    )
