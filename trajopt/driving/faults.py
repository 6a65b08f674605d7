"""Faults of a simulated robot, on request: what drivers and planners have to live with."""

from dataclasses import dataclass
from enum import Enum

from trajopt.values.arrays import Value, number
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked


class FaultKind(Enum):
    """Kinds of faults."""

    DRIFT = "drift"
    """A joint is driven to a place that is off by so much [rad | m]."""
    STUCK = "stuck"
    """A joint does not move any more."""
    LOST_COMMANDS = "lost commands"
    """What is spliced in is acknowledged, but never driven."""


@checked
@dataclass(frozen=True, kw_only=True)
class Fault(Value):
    """Something that goes wrong for a while.

    Attributes:
        kind: What.
        begin: From when on [s].
        end: Until when [s].
        joint: Which joint; of lost commands, none.
        size: By how much it drifts [rad | m].
    """

    kind: FaultKind
    begin: float
    end: float
    joint: str = ""
    size: float = 0.0

    def __post_init__(self) -> None:
        """Check that it lasts, and whether it names a joint.

        Raises:
            ProblemError: If it does not last, or names no joint, or one that it has no use for.
        """
        if not number("begin", self.begin) < number("end", self.end):
            raise ProblemError(f"a fault ends after it begins: {self.begin:g} s, {self.end:g} s")
        if bool(self.joint) == (self.kind is FaultKind.LOST_COMMANDS):
            raise ProblemError(
                "lost commands are of all joints"
                if self.joint
                else f"{self.kind.value} is of a joint: name it"
            )

    @checked
    def at(self, time: float) -> bool:
        """Say whether it is there at a time [s]."""
        return self.begin <= time < self.end
