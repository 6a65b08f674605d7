"""The best motion of a search among dynamic obstacles."""

from dataclasses import dataclass
from math import inf

from trajopt.planning.result import Result
from trajopt.planning.status import Certainty, Status


@dataclass(eq=False)
class BestMotion:
    """The best result of a search: a verified motion, or the failure that came nearest to one.

    Attributes:
        result: The result.
    """

    result: Result

    def learn(self, found: Result) -> None:
        """Keep a result if it is better: verified before late before refused, and then by duration."""
        self.result = min(found, self.result, key=_order)

    @property
    def verified(self) -> bool:
        """Whether there is a motion."""
        return self.result.verified

    @property
    def impossible(self) -> bool:
        """Whether it is proven that there is none."""
        return not self.verified and self.result.certainty is Certainty.PROVEN

    @property
    def duration(self) -> float:
        """Duration of the motion [s]; infinite if there is none."""
        return self.result.cost


def _order(result: Result) -> tuple[bool, bool, bool, float]:
    late = result.status is Status.TOO_LATE and result.trajectory is not None
    duration = inf if result.trajectory is None else result.trajectory.duration
    proven = result.certainty is Certainty.PROVEN
    return not result.verified, not proven, not late, duration
