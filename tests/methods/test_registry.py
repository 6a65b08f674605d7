"""Methods by name, and what planning does with one that cannot do what is asked."""

from collections.abc import Sequence
from dataclasses import dataclass

import pytest

import trajopt as to
from trajopt.arrays import Floats
from trajopt.errors import SolverNotFound
from trajopt.methods import METHODS, Program, method_named


@pytest.mark.parametrize("name", METHODS)
def test_methods_carry_the_name_they_are_known_by(name: str) -> None:
    assert method_named(name).name == name


def test_an_unknown_method_names_the_near_ones() -> None:
    with pytest.raises(SolverNotFound, match="sqp-osqp"):
        method_named("sqp-osqb")


@dataclass(frozen=True)
class OnlyTwoKnots:
    name: str = "two knots"

    def objection(self, problem: to.Problem) -> str:
        return "takes two knots" if problem.knots > 2 else ""

    def program(self, problem: to.Problem, seed: Floats, waypoint_knots: Sequence[int] = ()) -> Program:
        raise AssertionError("asked after it had objected")


def test_an_objection_comes_before_anything_starts() -> None:
    result = to.plan(to.named_problem("planar_fold"), method=OnlyTwoKnots())
    assert result.status is to.Status.METHOD_CANNOT
    assert result.message == "two knots: takes two knots"
    assert not result.counts
