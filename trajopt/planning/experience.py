"""What planning asks of experience: paths of motions that it remembers, and where it is told of new ones."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from trajopt.arrays import Floats, Value
from trajopt.problem import Problem

if TYPE_CHECKING:
    from trajopt.planning.result import Result


@dataclass(frozen=True, eq=False)
class Recalled(Value):
    """What was remembered of motions for problems much like one.

    Attributes:
        version: Of the memory: how often it had changed by then.
        memories: The numbers of the memories, the best first.
        seeds: The knots of their paths, shape (k, n) each [rad | m].
    """

    version: int
    memories: tuple[int, ...] = ()
    seeds: tuple[Floats, ...] = ()

    def as_dict(self) -> dict[str, object]:
        """Return plain data that JSON can hold, without the paths."""
        return {"version": self.version, "memories": list(self.memories)}


@runtime_checkable
class Remembers(Protocol):
    """What remembers motions; `trajopt.experience.Experience` does."""

    def recall(self, problem: Problem) -> Recalled:
        """Return what is worth trying first for a problem."""
        ...

    def learn(self, problem: Problem, result: "Result", recalled: Recalled, given: int = 0) -> None:
        """Note what became of a problem, and of what was recalled for it.

        Args:
            problem: The problem.
            result: What planning answered.
            recalled: What `recall` returned before.
            given: How many paths were tried before those, because the caller gave them.
        """
        ...
