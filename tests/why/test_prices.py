"""Prices are what they say: shift the bound, solve again, and the objective falls by the price."""

from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from tests.why.conftest import GOAL, START
from trajopt.optimise.nlp import ConstraintRows, CostRows, Linearisation
from trajopt.optimise.transcription import KnotsNlp, transcribe
from trajopt.values.arrays import Loss, Rows
from trajopt.why.prices import TIGHT, Price, multipliers, prices


def one_variable(value: float) -> tuple[Rows, np.ndarray]:
    zero = np.zeros(1, dtype=np.int64)
    return Rows(np.array([value]), np.ones((1, 1, 1)), zero[None], zero, np.zeros(1)), np.array([[value]])


def test_multiplier_of_a_parabola_against_a_wall() -> None:
    """Least (x - 3)^2 with x <= 1: the slope at 1 is -4, so a wall one unit further gains 4 per unit."""
    rows, x = one_variable(1.0)
    cost = CostRows("c", replace(rows, value=np.array([-2.0])), np.ones(1), Loss.SQUARED)
    wall = ConstraintRows("wall", rows, np.array([-np.inf]), np.array([1.0]), 1e-6)
    at = Linearisation(x, (cost,), (wall,), np.zeros(0, dtype=np.int64))
    wide = np.array([[10.0]])
    found = multipliers(at, -wide, wide)
    assert found.rows == {(object, "wall", 0): pytest.approx(4.0)}
    assert found.unbalanced == pytest.approx(0.0, abs=1e-12) and not found.bounds
    bound = multipliers(replace(at, constraints=()), -wide, np.array([[1.0]]))
    assert bound.bounds == {0: pytest.approx(4.0)} and not bound.rows


def test_multipliers_that_are_not_found_are_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """Among many rows that are nearly the same the search for them may not end."""

    def endless(*arguments: object) -> None:
        raise RuntimeError("Maximum number of iterations reached.")

    monkeypatch.setattr("scipy.optimize.nnls", endless)
    rows, x = one_variable(1.0)
    cost = CostRows("c", rows, np.ones(1), Loss.SQUARED)
    wall = ConstraintRows("wall", rows, np.array([-np.inf]), np.array([1.0]), 1e-6)
    at = Linearisation(x, (cost,), (wall,), np.zeros(0, dtype=np.int64))
    found = multipliers(at, np.array([[-9.0]]), np.array([[9.0]]))
    assert found.unbalanced == 1.0 and not found.rows and not found.bounds


def test_an_unbalanced_gradient_is_reported() -> None:
    rows, x = one_variable(1.0)
    cost = CostRows("c", rows, np.ones(1), Loss.SQUARED)
    at = Linearisation(x, (cost,), (), np.zeros(0, dtype=np.int64))
    assert multipliers(at, np.array([[-9.0]]), np.array([[9.0]])).unbalanced == pytest.approx(1.0)


def problem(scene: to.Scene, **changes: object) -> to.Problem:
    given = {"scene": scene, "start": START, "goal": to.joint_positions(GOAL), **changes}
    return to.Problem(**given)  # pyright: ignore[reportArgumentType]


def shifted(nlp: KnotsNlp, name: str, by: float) -> KnotsNlp:
    """Shift the bounds of a constraint outward."""
    return replace(
        nlp,
        constraints=tuple(
            replace(item, lower=item.lower - by, upper=item.upper + by)
            if item.residual.name == name
            else item
            for item in nlp.constraints
        ),
    )


@pytest.mark.parametrize("name", ["clearance", "joint positions"])
def test_prices_agree_with_finite_differences(pillar: to.Scene, name: str) -> None:
    asked = problem(pillar)
    path = to.plan(asked).require().path
    if name == "joint positions":
        strays = np.abs(path.knots[:, 2] - 0.3).max()
        held = to.joint_positions({"elbow": 0.3}, tolerance=0.9 * strays)
        asked = problem(pillar, constraints=[held])
    nlp = transcribe(asked, path.knots)
    solved = TIGHT.solve(nlp, path.knots)
    rows = multipliers(solved.at, nlp.lower, nlp.upper).rows
    told = sum(push for key, push in rows.items() if key.name == name)
    step = 2e-4
    costs = [TIGHT.solve(shifted(nlp, name, by), solved.x).at.cost for by in (-step, step)]
    assert told > 1e-3, "the constraint is active"
    assert told == pytest.approx((costs[0] - costs[1]) / (2.0 * step), rel=0.05)


def test_the_price_in_seconds_of_a_velocity_limit(arm: to.Robot) -> None:
    """A long way of one joint at full speed: a per cent of speed is a per cent of the time at it."""
    quick = replace(arm, limits=replace(arm.limits, acceleration=np.full(5, 60.0)))
    far = problem(
        to.Scene(quick), start={**START, "pan": -3.0}, goal=to.joint_positions({**GOAL, "pan": 3.0})
    )
    result = to.plan(far)
    found = {price.what: price for price in prices(result, seconds=True)}
    assert result.trajectory is not None
    price = found["velocity limit of pan"]
    assert price.unit == "%" and price.objective is None
    assert price.seconds == pytest.approx(0.01 * result.trajectory.duration, rel=0.15)


def test_the_price_of_a_margin_in_seconds_matches_planning_again(pillar: to.Scene) -> None:
    asked = problem(pillar)
    result = to.plan(asked)
    found = [price for price in prices(result, seconds=True) if "pillar" in price.what]
    assert found and all(price.seconds is not None and price.objective is not None for price in found)
    assert max(price.seconds or 0.0 for price in found) > 0.0, "a smaller margin is a shorter way"


def test_a_failure_has_no_prices(pillar: to.Scene) -> None:
    assert prices(to.plan(problem(pillar, start={**START, "pan": 0.0}))) == ()


def test_words() -> None:
    price = Price(what="margin of a from b", unit="mm", objective=0.5, seconds=0.0123)
    assert (
        str(price) == "margin of a from b: 12.3 ms of the motion and 0.5 of the optimiser's objective per mm"
    )
