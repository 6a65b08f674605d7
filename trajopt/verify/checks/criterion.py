"""Criterion: one part of the judgement, which can be decided or measured."""

from abc import ABC, abstractmethod
from collections.abc import Iterable

from trajopt.verify.certificate import Check


class Criterion(ABC):
    """One part of the judgement.

    The judge decides its list of criteria to accept or reject a motion, and measures them to write a
    certificate. Both give the same verdict; deciding may stop early and skip measurements.
    """

    @abstractmethod
    def measure(self) -> Iterable[Check]:
        """Judge the criterion and return its checks with margins."""

    def holds(self) -> bool:
        """Decide whether every required check of `measure` holds."""
        return all(check.holds or not check.required for check in self.measure())
