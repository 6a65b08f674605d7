"""What the tests of every requirement are told of one kind: a table at the end of its own test file."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path

from tests.optimise.terms.worlds import World
from trajopt.problem.requirements import Requirement
from trajopt.problem.residual import Residual


@dataclass(frozen=True, eq=False, kw_only=True)
class Kind:
    """One kind of requirement.

    Attributes:
        requirement: Its class.
        printed: Requirements, each with its printed form.
        relaxed: Requirements of the odd arm, each of which can be relaxed.
        residuals: The class of each residual of its term -> what makes some in a world.
        measured: Those of them that have no CasADi expression.
        calls: Public function -> arguments with which it makes one.
    """

    requirement: type[Requirement]
    printed: Sequence[tuple[Requirement, str]]
    relaxed: Sequence[Requirement]
    residuals: Mapping[type, Sequence[Callable[[World], Residual]]]
    calls: Mapping[str, Mapping[str, object]]
    measured: frozenset[type] = field(default_factory=frozenset[type])


def kinds() -> tuple[Kind, ...]:
    """Every kind, of the test files in this folder."""
    here = Path(__file__).parent
    modules = (import_module(f"{__package__}.{path.stem}") for path in sorted(here.glob("test_*.py")))
    return tuple(module.KIND for module in modules if hasattr(module, "KIND"))
