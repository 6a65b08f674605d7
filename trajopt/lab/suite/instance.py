"""Instance: a problem to plan, by name, and how that is expected to end; definitions make them."""

import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from inspect import signature
from pathlib import Path

import numpy as np

from trajopt.planning.result import Status
from trajopt.problem.problem import Problem
from trajopt.values.arrays import one_of, sequence
from trajopt.values.errors import ProblemError, ProblemNotFound, shown
from trajopt.values.errors.arguments import checked

GROUP = "trajopt.problems"
"""The entry-point group that names problems, so any package can add some."""

STANDARD = (
    "past_pillar_panda",
    "cup_past_pillar",
    "bookshelf_panda",
    "level_tray_ur5",
    "narrow_mouth_xarm7",
    "planar_fold",
)
"""Default installed problems: few, short, of all arms."""

_EXPECTED = "expected_status"
"""Attribute that a function which makes a problem without a solution carries."""


@checked
def expected_status(status: Status) -> Callable[[Callable[..., Problem]], Callable[..., Problem]]:
    """Mark a function that makes a problem without a solution.

    Args:
        status: The expected status.

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
class Instance:
    """A problem, made on demand.

    Attributes:
        name: Its name; in a set "set/number".
        make: Makes it; each call returns a new one.
        expected: The expected status.
        draw: 0, or the number of a random instance of an installed problem.
        files: Its scene, request and motions, if it is read from files.
    """

    name: str
    make: Callable[[], Problem]
    expected: Status = Status.SOLVED
    draw: int = 0
    files: tuple[Path, ...] = ()


@dataclass(frozen=True)
class Definition:
    """A function that makes a problem, known by name.

    Attributes:
        name: Its name, among the installed problems or in a comparison.
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

    @checked
    def instance(self, draw: int = 0) -> Instance:
        """Return an instance.

        Args:
            draw: 0 for the fixed instance, else the number of a random one: the same on every machine.

        Raises:
            ProblemError: If there are no random instances.
        """
        if draw == 0:
            return Instance(self.name, self.make, self.expected)
        if not self.randomised:
            raise ProblemError(f"problem {shown(self.name)} has no random instances")

        def drawn() -> Problem:
            return self.make(rng=np.random.default_rng((zlib.crc32(self.name.encode()), draw)))

        return Instance(self.name, drawn, self.expected, draw)


def definitions() -> tuple[Definition, ...]:
    """Return the installed problems, by name."""
    from importlib.metadata import entry_points

    installed = {entry.name: entry for entry in entry_points(group=GROUP)}
    return tuple(Definition(name, installed[name].load()) for name in sorted(installed))


@checked
def installed_definitions(names: Sequence[str] = ()) -> tuple[Definition, ...]:
    """Return installed problems.

    Args:
        names: Their names, in this order; all if empty.

    Raises:
        ProblemNotFound: If there is none of a name.
    """
    known = {item.name: item for item in definitions()}
    for name in names:
        if name not in known:
            raise ProblemNotFound("installed problem", name, known)
    return tuple(known[name] for name in names or known)


@checked
def installed_instances(names: Sequence[str] = ()) -> tuple[Instance, ...]:
    """Return the fixed instances of installed problems.

    Args:
        names: Their names, in this order; all if empty.

    Raises:
        ProblemNotFound: If there is none of a name.
    """
    return tuple(item.instance() for item in installed_definitions(names))


def instances_of(problems: Mapping[str, Problem] | Sequence[Problem | str]) -> tuple[Instance, ...]:
    """Return problems as instances.

    Args:
        problems: By name; or a sequence of problems (with their own names) or names of installed ones.

    Raises:
        ProblemNotFound: If there is no installed problem of a name.
    """

    def fixed(name: str, problem: Problem) -> Instance:
        return Instance(name, lambda: problem)

    if isinstance(problems, Mapping):
        return tuple(fixed(name, problem) for name, problem in problems.items())
    listed: list[Instance] = []
    for item in sequence("problems", problems):
        if isinstance(item, str):
            listed.extend(installed_instances((item,)))
        else:
            problem = one_of("problem", item, Problem)
            listed.append(fixed(problem.name, problem))
    return tuple(listed)
