"""A small input with a large number ends at once: in a plan, in a reason, or in an error that names it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from tests.planning.walls import wall
from tests.robots_for_tests import odd_arm
from trajopt.optimise.terms import Cost, Velocity
from trajopt.simulation import simulate
from trajopt.timing import RetimeFailure, retime
from trajopt.values.errors import ProblemError, ShapeError, SizeError
from trajopt.values.trajectory import Path

pytestmark = pytest.mark.timeout(60)


@pytest.fixture(scope="module")
def problem(tmp_path_factory: pytest.TempPathFactory) -> to.Problem:
    return wall(odd_arm(tmp_path_factory.mktemp("robot")), inner_edge=1.5)


REFUSED: dict[str, tuple[Callable[[to.Problem], object], type[Exception], str]] = {
    "knots": (lambda problem: replace(problem, knots=100_000), ProblemError, "3 to 2000, not 100000"),
    "slow tool": (lambda _: to.tool_speed("tip", linear=1e-300), ProblemError, "1e-09 m/s is the least"),
    "slow turn": (lambda _: to.tool_speed("tip", angular=1e-10), ProblemError, "1e-09 rad/s is the least"),
    "far goal": (lambda _: to.placement((1e300, 0.0, 0.0)), SizeError, "1e+06 m is the farthest"),
    "heavy cost": (lambda _: Cost(Velocity(), 1e300), ProblemError, "1e+12 is the most"),
    "infinite cost": (lambda _: Cost(Velocity(), np.inf), ShapeError, "not finite"),
    "no cost": (lambda _: Cost(Velocity(), np.nan), ShapeError, "must be a number, is nan"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_implausible_values_are_refused(problem: to.Problem, name: str) -> None:
    asked, error, words = REFUSED[name]
    with pytest.raises(error) as raised:
        asked(problem)
    assert words in str(raised.value)


def test_a_slow_tool_is_planned_or_reported(problem: to.Problem) -> None:
    frame = problem.scene.robot.links[-1]
    slow = to.plan(replace(problem, tool_speed=to.tool_speed(frame, linear=1e-5)))
    assert slow.verified and slow.trajectory is not None and slow.trajectory.duration > 1e4
    asked = replace(problem, tool_speed=to.tool_speed(frame, linear=1e-9))
    slower = to.plan(asked, budget=to.Budget(attempts=1))
    assert slower.status is to.Status.NO_TIMING and "1e+06 s are the most" in slower.reason
    assert "load" not in slower.reason


@pytest.mark.parametrize("kind", ["velocity", "acceleration", "jerk"])
@pytest.mark.parametrize("limit", [1e-30, 1e-300])
def test_a_tiny_joint_limit_is_reported(problem: to.Problem, kind: str, limit: float) -> None:
    limits = problem.limits
    column = np.full(len(limits.joint_names), 1.0)
    column[0] = limit
    knots = np.stack((problem.reduced.start_positions, problem.reduced.start_positions + 0.3))
    found = retime(Path(limits.joint_names, knots), replace(limits, **{kind: column}))
    assert isinstance(found, RetimeFailure) and found.joint == limits.joint_names[0]
    assert kind in found.reason and f"{limit:g}" in found.reason


def test_a_simulation_of_too_many_steps_is_refused(problem: to.Problem) -> None:
    found = to.plan(replace(problem, velocity_scaling=1e-5)).trajectory
    assert found is not None
    with pytest.raises(ProblemError, match="simulate a part"):
        simulate(problem.reduced, found)
