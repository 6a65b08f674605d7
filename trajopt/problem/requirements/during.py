"""Something that must hold on a part of the motion only: between two waypoints, or from or until one."""

from dataclasses import dataclass
from typing import Generic, TypeVar

from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked

Required_co = TypeVar("Required_co", covariant=True)
Required = TypeVar("Required")


@dataclass(frozen=True)
class During(Generic[Required_co]):
    """Something that must hold on a part of the motion, its ends included.

    Attributes:
        required: What must hold there.
        after: The waypoint from which it holds; None for the start.
        until: The waypoint up to which it holds; None for the end.
    """

    required: Required_co
    after: str | None
    until: str | None

    @property
    def part(self) -> str:
        """The part in words."""
        return f"from {self.after or 'the start'} to {self.until or 'the end'}"

    def __str__(self) -> str:
        """Show what must hold, and where."""
        return f"{self.required}, {self.part}"


@checked
def during(required: Required, *, after: str | None = None, until: str | None = None) -> During[Required]:
    """Require something on a part of the motion only.

    Args:
        required: What must hold there: a requirement, or a constraint on a residual.
        after: Name of the waypoint from which it holds; from the start on when None.
        until: Name of the waypoint up to which it holds; to the end when None.

    Raises:
        ProblemError: If it is for the whole motion, which needs no `during`.
    """
    if after is None and until is None:
        raise ProblemError("during: name the waypoint from which or up to which it holds")
    return During(required, after, until)
