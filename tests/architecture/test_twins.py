"""Every requirement has a term in the program and a check of the judge, each of its own."""

import inspect
from pathlib import Path

import pytest

import trajopt.terms  # noqa: F401  (terms register themselves on import)
from trajopt.model import requirements
from trajopt.model.requirements import Requirement
from trajopt.terms.requirement import constrain
from trajopt.verify.checks.quantities import quantities

KINDS = [
    value
    for _, value in inspect.getmembers(requirements, inspect.isclass)
    if issubclass(value, Requirement) and value is not Requirement
]


def test_there_are_some() -> None:
    assert len(KINDS) >= 3
    known = {kind for kind in Requirement.__subclasses__() if kind.__module__.startswith("trajopt.")}
    assert known == set(KINDS), "a requirement lives in trajopt.model.requirements"


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_term_and_check_are_registered_apart(kind: type) -> None:
    term, numbers = constrain.dispatch(kind), quantities.dispatch(kind)
    assert term is not constrain.dispatch(object), f"{kind.__name__} has no term"
    assert numbers is not quantities.dispatch(object), f"{kind.__name__} has no check"
    homes = [Path(inspect.getfile(function)).parent.name for function in (term, numbers)]
    assert homes == ["terms", "checks"]
