"""Definition: an installed function that makes a problem, and how planning it is expected to end."""

import zlib
from collections.abc import Callable
from dataclasses import dataclass
from inspect import signature

import numpy as np

from trajopt.errors import ProblemError
from trajopt.planning.result import Status
from trajopt.problem import Problem

GROUP = "trajopt.problems"
"""The entry-point group that names problems, so any package can add some."""

_EXPECTED = "expected_status"
"""Attribute that a function which makes a problem without a solution carries."""


def expected_status(status: Status) -> Callable[[Callable[..., Problem]], Callable[..., Problem]]:
    """Mark a function as one that makes a problem without a solution.

    Args:
        status: How planning must end.

    Returns:
        A decorator that returns the function itself; without it a problem is expected to be solved.

    Raises:
        ProblemError: If the status is that of a solved problem.
    """
    if status is Status.SOLVED:
        raise ProblemError("expected_status: SOLVED is expected of every problem without it")

    def mark(make: Callable[..., Problem]) -> Callable[..., Problem]:
        setattr(make, _EXPECTED, status)
        return make

    return mark


@dataclass(frozen=True)
class Definition:
    """A function that makes a problem, known by name.

    Attributes:
        name: Its name among the installed problems.
        make: The function; with an argument `rng` it makes random instances too.
    """

    name: str
    make: Callable[..., Problem]

    @property
    def expected(self) -> Status:
        """How planning is expected to end."""
        status = getattr(self.make, _EXPECTED, Status.SOLVED)
        assert isinstance(status, Status)
        return status

    @property
    def randomised(self) -> bool:
        """Whether there are random instances."""
        return "rng" in signature(self.make).parameters

    def problem(self, draw: int = 0) -> Problem:
        """Return an instance.

        Args:
            draw: 0 for the fixed instance, else the number of a random one: the same on every machine.

        Raises:
            ProblemError: If there are no random instances.
        """
        if draw == 0:
            return self.make()
        if not self.randomised:
            raise ProblemError(f"problem {self.name!r} has no random instances")
        return self.make(rng=np.random.default_rng((zlib.crc32(self.name.encode()), draw)))


def definitions() -> tuple[Definition, ...]:
    """Return the installed problems, by name."""
    from importlib.metadata import entry_points

    installed = {entry.name: entry for entry in entry_points(group=GROUP)}
    return tuple(Definition(name, installed[name].load()) for name in sorted(installed))
