"""Criterion: one part of everything that a motion must do, which can be decided or measured."""

from abc import ABC, abstractmethod
from collections.abc import Iterable

from trajopt.verify.certificate import Check


class Criterion(ABC):
    """One part of everything that a motion must do.

    The judge has one list of criteria: it decides them to accept or refuse a motion, and measures them to
    write a certificate. Both give the same verdict; deciding may stop early and skip the measuring.
    """

    @abstractmethod
    def measure(self) -> Iterable[Check]:
        """Judge the criterion and measure how nearly it holds: the rows of a certificate."""

    def holds(self) -> bool:
        """Decide whether every required check of `measure` holds."""
        return all(check.holds or not check.required for check in self.measure())
