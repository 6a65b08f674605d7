"""Remedies: the smallest changes that make a problem solvable, found and checked by planning."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np

from trajopt.planning.result import Result
from trajopt.problem.problem import Problem
from trajopt.why.change import Change

MOST = 3
"""Largest number of remedies."""
DOUBLINGS = 4
"""Number of doublings of an insufficient amount."""
HALVINGS = 8
"""Number of halvings of a sufficient amount before the change counts as unnecessary."""
BISECTIONS = 3
"""Steps between an insufficient and a sufficient amount, at most twice as large."""

Plan = Callable[[Problem], Result]
"""Plans a problem."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Remedy:
    """A change that makes a problem solvable, while half of it does not: both were planned.

    Attributes:
        words: The change.
        what: The changed item.
        amount: The amount.
        unit: Unit of the amount.
        problem: The changed problem.
        result: The verified plan of it.
        half: The failure with half of the change.
    """

    words: str
    what: str
    amount: float
    unit: str
    problem: Problem
    result: Result
    half: Result

    def as_dict(self) -> dict[str, object]:
        """Return plain data that JSON can hold."""
        return {
            "words": self.words,
            "what": self.what,
            "amount": self.amount,
            "unit": self.unit,
            "half": self.half.reason,
        }

    def __str__(self) -> str:
        """Return the change."""
        return self.words


def smallest_changes(changes: Iterable[Change], plan: Plan) -> tuple[Remedy, ...]:
    """Try changes, the most promising first, until some make the problem solvable.

    Args:
        changes: The changes, each with a likely sufficient amount.
        plan: Plans a problem.
    """
    found: list[Remedy] = []
    for change in changes:
        if len(found) == MOST:
            break
        remedy = _Search(change, plan).smallest()
        if remedy is not None:
            found.append(remedy)
    return tuple(found)


@dataclass(eq=False)
class _Search:
    """Search of the smallest sufficient amount of one change; every amount is planned once."""

    change: Change
    plan: Plan
    planned: dict[float, Result] = field(default_factory=dict[float, Result])

    def smallest(self) -> Remedy | None:
        """Double until sufficient, halve until not, bisect, round, and check both again."""
        enough = self._enough()
        if enough is not None and not self.change.whole:
            enough = self._smaller(enough)
        if enough is None or self._solves(enough / 2.0):
            return None
        return Remedy(
            words=self.change.words(enough),
            what=self.change.what,
            amount=enough,
            unit=self.change.unit,
            problem=self._result(enough).problem,
            result=self._result(enough),
            half=self._result(enough / 2.0),
        )

    def _smaller(self, enough: float) -> float | None:
        """Return the smallest sufficient amount, rounded; None if every amount seems sufficient."""
        for _ in range(HALVINGS):
            if not self._solves(enough / 2.0):
                break
            enough /= 2.0
        else:
            return None
        enough = self._bisected(enough)
        rounded = min(_rounded_up(enough), self.change.largest)
        return rounded if self._solves(rounded) else enough

    def _enough(self) -> float | None:
        amount = min(self.change.first, self.change.largest)
        for _ in range(DOUBLINGS):
            if self._solves(amount):
                return amount
            if amount >= self.change.largest:
                return None
            amount = min(2.0 * amount, self.change.largest)
        return amount if self._solves(amount) else None

    def _bisected(self, enough: float) -> float:
        """Bisect the smallest sufficient amount, half of which is insufficient."""
        short = enough / 2.0
        for _ in range(BISECTIONS):
            middle = (short + enough) / 2.0
            if self._solves(middle):
                enough = middle
            else:
                short = middle
        return enough

    def _solves(self, amount: float) -> bool:
        return self._result(amount).verified

    def _result(self, amount: float) -> Result:
        if amount not in self.planned:
            self.planned[amount] = self.plan(self.change.apply(amount))
        return self.planned[amount]


def _rounded_up(amount: float) -> float:
    """Round up to two significant digits."""
    digit = 10.0 ** (np.floor(np.log10(amount)) - 1.0)
    return float(np.ceil(amount / digit - 1e-9) * digit)
