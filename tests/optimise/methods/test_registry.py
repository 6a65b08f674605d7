"""Methods by name, and what planning does with one that cannot do what is asked."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from tests.test_plan import START
from trajopt.optimise.methods import METHODS, Program, method_named, method_names
from trajopt.values.arrays import Floats
from trajopt.values.errors import SolverNotFound


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


def test_all_names_are_known() -> None:
    assert {"sqp", "chomp", "stomp", "sqp-osqp", "sqp-proxqp-dense", "sqp-quadprog"} <= set(method_names())
    assert len(set(method_names())) == len(method_names())


@pytest.mark.parametrize("name", ["chomp", "stomp"])
def test_others_than_the_sqp_keep_path_constraints_and_free_ends(name: str, tmp_path: Path) -> None:
    pillar = to.Scene(odd_arm(tmp_path)).add("pillar", to.Cylinder(0.08, 1.0), to.placement((0.72, 0.0, 0.3)))
    problem = to.Problem(
        scene=pillar,
        start=START,
        goal=to.joint_positions({"pan": 1.0, "elbow": 0.4}, tolerance=0.05),
        constraints=[to.joint_positions({"wrist": 0.1}, tolerance=0.15)],
    )
    result = to.plan(problem, method=method_named(name))
    assert result.verified, result.explain()
