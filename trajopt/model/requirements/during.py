"""Something that must hold on a part of the motion only: between two waypoints, or from or until one."""

from dataclasses import dataclass
from typing import Generic, TypeVar

from trajopt.errors import ProblemError

Asked_co = TypeVar("Asked_co", covariant=True)
Asked = TypeVar("Asked")


@dataclass(frozen=True)
class During(Generic[Asked_co]):
    """What is asked, and the part of the motion that it is for, its ends included.

    Attributes:
        required: What must hold there.
        after: The waypoint from which it holds; None for the start.
        until: The waypoint up to which it holds; None for the end.
    """

    required: Asked_co
    after: str | None
    until: str | None

    @property
    def part(self) -> str:
        """The part in words."""
        return f"from {self.after or 'the start'} to {self.until or 'the end'}"

    def __str__(self) -> str:
        """Say what and when."""
        return f"{self.required}, {self.part}"


def during(required: Asked, *, after: str | None = None, until: str | None = None) -> During[Asked]:
    """Ask for something on a part of the motion only.

    Args:
        required: What must hold there: a requirement, or a constraint of your own.
        after: Name of the waypoint from which it holds; from the start on when None.
        until: Name of the waypoint up to which it holds; to the end when None.

    Raises:
        ProblemError: If it is for the whole motion, which needs no `during`.
    """
    if after is None and until is None:
        raise ProblemError("during: name the waypoint from which or up to which it holds")
    return During(required, after, until)
