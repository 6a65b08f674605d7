"""Question: a problem that methods are compared on, by name, made when it is its turn."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from trajopt.arrays import one_of, sequence
from trajopt.benchmark.definition import definitions
from trajopt.errors import ProblemNotFound
from trajopt.planning.status import Status
from trajopt.problem import Problem

STANDARD = (
    "past_pillar_panda",
    "cup_past_pillar",
    "bookshelf_panda",
    "level_tray_ur5",
    "narrow_mouth_xarm7",
    "planar_fold",
)
"""Installed problems that are taken where none is named: few, short, of all arms."""


@dataclass(frozen=True)
class Question:
    """A problem by name.

    Attributes:
        name: Its name in the comparison.
        make: Makes it.
        expected: How planning should end.
    """

    name: str
    make: Callable[[], Problem]
    expected: Status = Status.SOLVED


def installed_questions(names: Sequence[str] = ()) -> tuple[Question, ...]:
    """Return installed problems, their fixed instances.

    Args:
        names: Which; all when empty.

    Raises:
        ProblemNotFound: If there is none of a name.
    """
    known = {item.name: item for item in definitions()}
    for name in names:
        if name not in known:
            raise ProblemNotFound("installed problem", name, known)
    return tuple(Question(name, known[name].problem, known[name].expected) for name in names or known)


def given_questions(problems: Mapping[str, Problem] | Sequence[Problem | str]) -> tuple[Question, ...]:
    """Return problems as questions.

    Args:
        problems: By name; or in a row, each a problem (known by its own name) or an installed one's name.

    Raises:
        ProblemNotFound: If there is no installed problem of a name.
    """

    def giver(problem: Problem) -> Callable[[], Problem]:
        return lambda: problem

    if isinstance(problems, Mapping):
        return tuple(Question(name, giver(problem)) for name, problem in problems.items())
    found: list[Question] = []
    for item in sequence("problems", problems):
        if isinstance(item, str):
            found.extend(installed_questions((item,)))
        else:
            problem = one_of("problem", item, Problem)
            found.append(Question(problem.name, giver(problem)))
    return tuple(found)
