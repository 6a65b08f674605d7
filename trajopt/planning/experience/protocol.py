"""What planning asks of experience: paths of motions that it remembers, and where it is told of new ones."""

from typing import Protocol, runtime_checkable

from trajopt.planning.recalled import Recalled
from trajopt.planning.result import Result
from trajopt.problem.problem import Problem


@runtime_checkable
class Remembers(Protocol):
    """What remembers motions; `trajopt.planning.experience.Experience` does."""

    def recall(self, problem: Problem) -> Recalled:
        """Return what is worth trying first for a problem."""
        ...

    def learn(self, problem: Problem, result: Result, recalled: Recalled, given: int = 0) -> None:
        """Note what became of a problem, and of what was recalled for it.

        Args:
            problem: The problem.
            result: What planning answered.
            recalled: What `recall` returned before.
            given: How many paths were tried before those, because the caller gave them.
        """
        ...
