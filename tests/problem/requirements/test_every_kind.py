"""Every kind of requirement has data, a term and a check in files of its subject, one export, and tests."""

import ast
import re
from dataclasses import dataclass
from inspect import getfile
from pathlib import Path

import pytest

import trajopt.optimise.terms  # noqa: F401  (terms register themselves on import)
from tests.architecture.import_graph import PACKAGE, ROOT
from tests.problem.requirements.kind import kinds
from tests.problem.requirements.sound import END, check, reach
from trajopt.optimise.terms.requirement import constrain
from trajopt.problem.requirement import Requirement, import_subject
from trajopt.scene.reduced import ReducedModel
from trajopt.values.errors import ProblemError
from trajopt.verify import When
from trajopt.verify.checks.quantities import quantities

KINDS = [kind for kind in Requirement.__subclasses__() if kind.__module__.startswith("trajopt.")]
FACADES = {PACKAGE / "tasks" / "cartesian" / "__init__.py"}
"""`trajopt.tasks.cartesian` shows what its users hold in their hands, a curve that is followed among it."""


def file_name(kind: type[Requirement]) -> str:
    return re.sub(r"(?<!^)(?=[A-Z])", "_", kind.__name__).lower() + ".py"


def exporting(names: set[str]) -> set[Path]:
    """The files of the library that hand names on to others."""
    found: set[Path] = set()
    for path in PACKAGE.rglob("__init__.py"):
        imported = (
            node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.ImportFrom)
        )
        if any(alias.name in names for node in imported for alias in node.names):
            found.add(path)
    return found - FACADES


def test_there_are_some() -> None:
    assert len(KINDS) >= 12


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_a_kind_has_data_and_check_in_files_of_one_subject(kind: type[Requirement]) -> None:
    subject, name = kind.__module__.split(".")[-1], file_name(kind)
    assert PACKAGE / "problem" / "requirements" / f"{subject}.py" == Path(getfile(kind))
    import_subject(kind, "trajopt.verify.checks")
    assert quantities.dispatch(kind).__module__ == f"trajopt.verify.checks.{subject}"
    assert len(exporting({kind.__name__, name.removesuffix(".py")})) == 1
    assert (ROOT / "tests" / "problem" / "requirements" / f"test_{name}").exists()


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_term_and_check_are_registered_apart(kind: type[Requirement]) -> None:
    import_subject(kind, "trajopt.verify.checks")
    term, numbers = constrain.dispatch(kind), quantities.dispatch(kind)
    assert term is not constrain.dispatch(object), f"{kind.__name__} has no term"
    assert numbers is not quantities.dispatch(object), f"{kind.__name__} has no check"
    assert term.__module__.split(".")[-2] == "terms" and numbers.__module__.split(".")[-2] == "checks"


def test_the_shared_tests_know_every_kind() -> None:
    """Printed forms, relaxations, derivatives and junk take what they try from the kinds' own files."""
    assert {known.requirement for known in kinds()} == set(KINDS)
    for known in kinds():
        assert known.printed and known.relaxed and known.residuals and known.calls, known.requirement
        assert all(type(item) is known.requirement for item, _ in known.printed)
        assert all(type(item) is known.requirement for item in known.relaxed)


def test_an_unknown_requirement_is_refused(model: ReducedModel) -> None:
    @dataclass(frozen=True)
    class Strange(Requirement):
        pass

    with pytest.raises(ProblemError, match="Strange"):
        check(model, reach(model, END), Strange(), When.END)
