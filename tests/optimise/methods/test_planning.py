"""Every method plans problems of the suite, says what it cannot do, and is never worse than its seed."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from trajopt.optimise.methods import Decoded, Knots, method_named
from trajopt.optimise.methods.bspline import Bspline
from trajopt.optimise.methods.free_duration import FreeDuration, FreeDurationProgram
from trajopt.optimise.solvers import SolveResult
from trajopt.optimise.terms import Cost, Velocity, Window, constraint, penalty, residual_from_function
from trajopt.values.arrays import Floats
from trajopt.values.errors import ProblemError

METHODS = ("ipopt", "fatrop", "sqpmethod", "bspline", "free-duration")
PROBLEMS = ("planar_fold", "past_pillar_ur5", "cup_past_pillar")


@pytest.mark.parametrize("problem", PROBLEMS)
@pytest.mark.parametrize("method", METHODS)
def test_plans(method: str, problem: str) -> None:
    result = to.plan(to.named_problem(problem), method=method_named(method))
    assert result.status is to.Status.SOLVED, result.explain()
    assert result.solve is not None and result.solve.feasible
    assert method == "fatrop" or result.solve.log


@pytest.mark.parametrize("problem", PROBLEMS)
def test_free_duration_is_never_slower_than_its_seed(problem: str) -> None:
    asked = to.named_problem(problem)
    seed, found = to.plan(asked), to.plan(asked, method=FreeDuration())
    assert seed.trajectory is not None and found.trajectory is not None
    assert found.timed is None
    assert found.trajectory.duration <= seed.trajectory.duration + 1e-9


def test_a_refused_motion_leaves_the_seed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A motion that ignores the obstacle is refused by the judge, and the timed path is planned instead."""
    asked = to.named_problem("past_pillar_ur5")
    decode = FreeDurationProgram.decode

    def through_the_pillar(self: FreeDurationProgram, solved: SolveResult) -> Sequence[Decoded]:
        first, *others = decode(self, solved)
        if first.trajectory is None:
            return (first, *others)
        ends = first.trajectory.positions[[0, -1]]
        straight = to.Trajectory(first.trajectory.joint_names, np.array((0.0, 9.0)), ends, 0 * ends, 0 * ends)
        return (replace(first, trajectory=straight), *others)

    monkeypatch.setattr(FreeDurationProgram, "decode", through_the_pillar)
    result = to.plan(asked, method=FreeDuration())
    assert result.status is to.Status.SOLVED and result.timed is not None


def test_spline_of_degree_five_and_of_many_pieces() -> None:
    for method in (Bspline(degree=5), Bspline(pieces=40)):
        assert to.plan(to.named_problem("past_pillar_ur5"), method=method).verified


def test_options_that_make_no_spline_are_refused() -> None:
    with pytest.raises(ProblemError, match="degree"):
        Bspline(degree=4)
    with pytest.raises(ProblemError, match="piece"):
        Bspline(pieces=0)


def test_ones_own_function_is_held_through_a_callback() -> None:
    asked = to.named_problem("planar_fold")
    joint = constraint(residual_from_function("first joint", lambda q: q[0]), lower=-np.inf, upper=3.0)
    result = to.plan(
        replace(asked, constraints=(*asked.constraints, joint)), method=method_named("sqpmethod")
    )
    assert result.status is to.Status.SOLVED, result.explain()


@pytest.mark.parametrize("method", ["ipopt", "sqpmethod"])
def test_exceptions_of_users_functions_are_raised(method: str) -> None:
    asked = to.named_problem("planar_fold")
    seen: list[Floats] = []

    def fails(positions: Floats) -> float:
        seen.append(positions)
        if len(seen) > 2000:
            raise ArithmeticError("mine")
        return 0.5 if positions[0] < 9.0 else 2.0

    item = constraint(residual_from_function("mine", fails), lower=0.0, upper=1.0)
    with pytest.raises(ArithmeticError, match="mine"):
        to.plan(replace(asked, constraints=(item,)), method=method_named(method))


def test_unsupported_problems_are_refused_before_the_start() -> None:
    class Mine:
        name = "mine"

        def linearise(self, motion: object) -> object:
            raise AssertionError("asked after it had been objected to")

    asked = to.named_problem("planar_fold")
    strange = constraint(Mine(), lower=0.0, upper=1.0)  # pyright: ignore[reportArgumentType]
    result = to.plan(replace(asked, constraints=(strange,)), method=method_named("ipopt"))
    assert result.status is to.Status.METHOD_CANNOT and "'mine'" in result.message
    away = penalty(to.joint_positions({asked.reduced.joint_names[0]: 0.0}, tolerance=0.1), 1.0)
    result = to.plan(replace(asked, costs=(*(asked.costs or ()), away)), method=method_named("fatrop"))
    assert result.status is to.Status.METHOD_CANNOT and "kink" in result.message
    early = Cost(Velocity(), window=Window(0.0, 0.5))
    for method in ("bspline", "free-duration"):
        result = to.plan(replace(asked, costs=(early,)), method=method_named(method))
        assert result.status is to.Status.METHOD_CANNOT and "part of the motion" in result.message
    assert to.plan(replace(asked, costs=(Cost(Velocity()), early)), method=method_named("sqpmethod")).verified
    assert not Knots().objection(asked)
