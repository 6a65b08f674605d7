"""Summary: how planning ended and why, as every `explain()` returns it."""

from dataclasses import dataclass

from trajopt.planning.status import Certainty, Status
from trajopt.values.arrays import Value
from trajopt.values.printed import in_short


@dataclass(frozen=True, eq=False, kw_only=True)
class Summary(Value):
    """How planning ended and why: `print` it, or read its parts.

    Attributes:
        status: How planning ended.
        reason: The result's own sentence.
        certainty: Whether the verdict is proven.
        grounds: Why it is known, or how much speaks for it.
        details: Particulars, one a line.
    """

    status: Status
    reason: str
    certainty: Certainty
    grounds: str
    details: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, object]:
        """Return plain data that JSON can hold."""
        return {
            "status": self.status.name,
            "reason": self.reason,
            "certainty": self.certainty.name,
            "grounds": self.grounds,
            "details": list(self.details),
        }

    def __repr__(self) -> str:
        """Say the verdict and how well it is known."""
        return in_short(f"{type(self).__name__}({self.status.name}, {self.certainty.value}: {self.grounds})")

    def __str__(self) -> str:
        """Return a line for each part."""
        lines = [self.reason, f"This is {self.certainty.value}: {self.grounds}."]
        return "\n".join([*lines, *(f"  {line}" for line in self.details)])
