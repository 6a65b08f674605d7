"""Definitions: what a function that makes a problem says of itself."""

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.lab.suite import Definition, run
from trajopt.values.errors import ProblemError


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    return odd_arm(tmp_path_factory.mktemp("robot"))


@pytest.fixture
def turning(arm: to.Robot) -> Definition:
    def make(rng: np.random.Generator | None = None) -> to.Problem:
        pan = 1.0 if rng is None else float(rng.uniform(0.5, 1.0))
        return to.Problem(scene=to.Scene(arm), start={}, goal=to.joint_positions({"pan": pan}))

    return Definition("turning", make)


def test_instances(turning: Definition) -> None:
    def goal(draw: int) -> float:
        (asked,) = turning.instance(draw).make().goals
        return asked.positions["pan"]  # pyright: ignore[reportAttributeAccessIssue]

    assert turning.randomised and turning.expected is to.Status.SOLVED
    assert goal(0) == 1.0
    assert goal(1) == goal(1) != goal(2)


def test_no_random_instances_without_rng(arm: to.Robot) -> None:
    definition = Definition("fixed", lambda: to.Problem(scene=to.Scene(arm), start={}, goal=()))
    assert not definition.randomised
    with pytest.raises(ProblemError, match="no random instances"):
        definition.instance(1)


def test_run_judges_the_motion(turning: Definition) -> None:
    outcome = run(turning.instance(2))
    assert outcome.good and outcome.instance == "random 2"
    told = {item.name.split(":")[0]: item for item in outcome.constraints}
    assert {"start", "goal", "velocity", "acceleration"} <= set(told)
    assert outcome.duration is not None and told["velocity"].time is not None
    assert 0.0 <= told["velocity"].time <= outcome.duration


def test_a_refused_problem_must_have_the_expected_reason(arm: to.Robot) -> None:
    def make() -> to.Problem:
        return to.Problem(scene=to.Scene(arm), start={}, goal=to.joint_positions({"reach": 9.0}))

    unmarked = run(Definition("beyond", make).instance())
    assert unmarked.status is to.Status.GOAL_OUT_OF_LIMITS and not unmarked.good
    right = to.suite.expected_status(to.Status.GOAL_OUT_OF_LIMITS)(make)
    assert run(Definition("beyond", right).instance()).good
    wrong = to.suite.expected_status(to.Status.STUCK)(make)
    assert not run(Definition("beyond", wrong).instance()).good


def test_solved_is_not_an_expected_refusal() -> None:
    with pytest.raises(ProblemError, match="SOLVED"):
        to.suite.expected_status(to.Status.SOLVED)
