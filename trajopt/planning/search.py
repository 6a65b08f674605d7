"""Search: candidates tried in their order until one is verified, or until the budget ends."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import count

from trajopt.infeasibility import closed_cut
from trajopt.infeasibility.reasons import blocks_on_the_way, walled_in
from trajopt.planning.budget import Stop
from trajopt.planning.meter import Meter, Stopped
from trajopt.planning.portfolio import ROUNDS, Candidate, Done, Portfolio, tried
from trajopt.planning.result import Result
from trajopt.planning.status import Certainty, Status
from trajopt.planning.tries import Try
from trajopt.planning.workers import tried_in_processes
from trajopt.problem import Problem

BEFORE_PROOF = 1
"""The round after whose failure a proof is looked for that there is no way at all."""
ENDED = {
    Stop.CLOCK: Status.OUT_OF_TIME,
    Stop.WORK: Status.OUT_OF_WORK,
    Stop.CANCEL: Status.CANCELLED,
}
"""How planning ends without a motion when it is stopped."""


@dataclass(eq=False)
class Search:
    """One call of planning: what it has tried, and the best motion so far.

    Attributes:
        problem: What was asked; may have a goal set.
        portfolios: First guesses for each goal.
        meter: What may be used, and what was.
        on_incumbent: Called with each verified motion that is better than the one before.
        incumbent: The best of those.
        tries: What each first guess came to.
    """

    problem: Problem
    portfolios: Sequence[Portfolio]
    meter: Meter
    on_incumbent: Callable[[Result], None] | None = None
    incumbent: Result | None = None
    tries: list[Try] = field(default_factory=list[Try])
    _refusals: dict[str, Result] = field(default_factory=dict[str, Result])

    def run(self) -> Result:
        """Search; return the best motion, or the reason why there is none.

        Raises:
            KeyboardInterrupt: If interrupted before there is a motion.
        """
        stopped: Stop | None = None
        try:
            self._search()
        except Stopped as ended:
            stopped = ended.stop
        except KeyboardInterrupt:
            if self.incumbent is None:
                raise
            stopped = Stop.CANCEL
        result = self.incumbent or self._failure(stopped)
        return self._complete(replace(result, stopped=stopped))

    def _search(self) -> None:
        for portfolio in self.portfolios:
            refusal = portfolio.prepare()
            if refusal is not None:
                self._refusals[portfolio.goal_name] = refusal
        open_ones = [item for item in self.portfolios if item.goal_name not in self._refusals]
        nearest_first = sorted(open_ones, key=lambda portfolio: portfolio.travel)
        budget = self.meter.budget
        for number in count() if nearest_first else ():
            if number == ROUNDS and not budget.bounded:
                return
            candidates = [item for portfolio in nearest_first for item in self._round_of(portfolio, number)]
            left = None if budget.tries is None else budget.tries - len(self.tries)
            for candidate, done in self._tried(candidates[:left], number):
                self._take(candidate, done)
                if self.incumbent is not None and not budget.improve:
                    return
            if budget.tries is not None and len(self.tries) >= budget.tries:
                return
            if number == BEFORE_PROOF and self.incumbent is None:
                nearest_first = [item for item in nearest_first if not self._walled_in(item)]
                if not nearest_first:
                    return

    def _walled_in(self, portfolio: Portfolio) -> bool:
        """Look for a proof that no other first guess can do better either."""
        stuck = portfolio.nearest
        if stuck is None or stuck.status is not Status.STUCK:
            return False
        with self.meter.stage("proof"):
            cut = closed_cut(portfolio.attempts.problem)
        if cut is not None:
            message = walled_in(stuck.problem, cut)
            portfolio.nearest = replace(
                stuck, status=Status.WALLED_IN, message=message, certainty=Certainty.PROVEN
            )
        return cut is not None

    def _round_of(self, portfolio: Portfolio, number: int) -> list[Candidate]:
        best = self.incumbent
        mine = best is not None and best.goal_name == portfolio.goal_name
        return portfolio.round(number, best if mine else None)

    def _tried(self, candidates: Sequence[Candidate], number: int) -> Iterator[tuple[Candidate, Done]]:
        workers = self.meter.budget.workers
        if number > 0 and min(workers, len(candidates)) > 1:
            return tried_in_processes(candidates, workers, self.meter)
        return ((item, tried(item.owner.attempts, item.way, item.guess, item.briefly)) for item in candidates)

    def _take(self, candidate: Candidate, done: Done) -> None:
        """Note what became of a candidate; keep it if it is better than the best so far."""
        candidate.owner.learn(candidate, done)
        told = _told(len(self.tries) + 1, candidate, done.result)
        self.tries.append(told)
        if done.result.cost < (float("inf") if self.incumbent is None else self.incumbent.cost):
            self.incumbent = replace(done.result, won=told, goal_name=candidate.owner.goal_name)
            if self.on_incumbent is not None:
                self.on_incumbent(self._complete(self.incumbent))

    def _failure(self, stopped: Stop | None) -> Result:
        """Return the failure that came nearest; of a goal set, with the reasons of all."""
        failures = {
            portfolio.goal_name: self._refusals.get(portfolio.goal_name) or portfolio.nearest
            for portfolio in self.portfolios
        }
        known = {name: failure for name, failure in failures.items() if failure is not None}
        looked_at = [item for item in self.portfolios if item.nearest is not None]
        if looked_at:
            first = known[min(looked_at, key=lambda portfolio: portfolio.travel).goal_name]
        elif known:
            first = next(iter(known.values()))
        else:
            first = self.portfolios[0].attempts.result(Status.CANCELLED, "nothing was tried")
        if self.problem.alternatives:
            message = "; ".join(f"{name}: {failure.reason}" for name, failure in known.items())
            nearest_first = sorted(known, key=lambda name: known[name] is not first)
            alternatives = {name: known[name] for name in nearest_first}
            proven = len(known) == len(failures) and all(
                failure.certainty is Certainty.PROVEN for failure in known.values()
            )
            first = replace(
                first,
                problem=self.problem,
                message=message,
                alternatives=alternatives,
                certainty=Certainty.PROVEN if proven else Certainty.EVIDENCE,
            )
        if stopped is None:
            return first
        message = first.message if self.problem.alternatives or not known else f"so far: {first.reason}"
        return replace(first, status=ENDED[stopped], message=message, certainty=Certainty.EVIDENCE)

    def _complete(self, result: Result) -> Result:
        """Add what planning did in all."""
        return replace(
            result,
            tries=tuple(self.tries),
            counts=dict(self.meter.counts),
            cpu_seconds=dict(self.meter.seconds),
        )


def _told(number: int, candidate: Candidate, result: Result) -> Try:
    solved = result.solve
    blocks = () if solved is None or result.verified else blocks_on_the_way(result.problem, solved)
    return Try(
        number=number,
        kind=candidate.kind,
        status=result.status,
        solver=None if solved is None else solved.status,
        message=result.message,
        iterations=0 if solved is None else len(solved.log),
        block=next(iter(blocks), None),
        goal_name=candidate.owner.goal_name,
    )
