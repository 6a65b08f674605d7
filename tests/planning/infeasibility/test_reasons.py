"""A residual is known by its class: a user's own that is named like a built-in one is not taken for it."""

from types import SimpleNamespace

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.optimise.kinematics.inverse import GoalCandidates
from trajopt.optimise.solvers import SolveResult, Sqp
from trajopt.optimise.terms import Clearance, Constraint, FunctionResidual, constraint, residual_from_function
from trajopt.optimise.terms.joint_positions import JointPosition
from trajopt.optimise.transcription import transcribe
from trajopt.planning.goal_search import _blocked  # pyright: ignore[reportPrivateUsage]
from trajopt.planning.infeasibility.reasons import ObstructionKind, blocks_on_the_way, no_goal_configuration
from trajopt.planning.result import Status
from trajopt.values.arrays import Floats
from trajopt.why import Certainty, Explanation
from trajopt.why.explain import candidates

START = {"pan": -0.3, "reach": 0.1, "elbow": 0.3, "wrist": 0.0}
GOAL = {**START, "pan": 0.3}


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> to.Scene:
    arm = odd_arm(tmp_path_factory.mktemp("robot"))
    return to.Scene(arm).add("pillar", to.Cylinder(0.05, 1.0), to.placement((0.3, -0.7, 0.3)))


def unholdable(name: str) -> Constraint:
    """A constraint that no configuration holds, as the last of more components than there are pairs."""

    def function(q: Floats) -> Floats:
        return np.append(np.zeros(999), 1.0 + q[0] ** 2)

    def jacobian(q: Floats) -> Floats:
        slope = np.zeros((1000, len(q)))
        slope[-1, 0] = 2.0 * q[0]
        return slope

    return constraint(residual_from_function(name, function, jacobian=jacobian), lower=-np.inf, upper=0.5)


def problem(scene: to.Scene, name: str) -> to.Problem:
    goal = to.joint_positions(GOAL)
    held = to.joint_positions({"elbow": 0.3}, tolerance=0.5)
    return to.Problem(scene=scene, start=START, goal=goal, constraints=[unholdable(name), held], knots=6)


def solved(asked: to.Problem) -> SolveResult:
    line = np.linspace(list(START.values()), list(GOAL.values()), asked.knots)
    return Sqp(max_iterations=3).solve(transcribe(asked, line), line)


def test_a_users_term_named_clearance_is_not_a_contact(scene: to.Scene) -> None:
    asked = problem(scene, Clearance.name)
    at = solved(asked)
    worst = blocks_on_the_way(asked, at)[0]
    assert worst.kind is ObstructionKind.REQUIREMENT and worst.subjects == ("clearance",)
    assert worst.residual is FunctionResidual
    assert _blocked(SimpleNamespace(solve=at)) == ()  # pyright: ignore[reportArgumentType]


def test_a_users_term_named_like_a_requirement_widens_none(scene: to.Scene) -> None:
    asked = problem(scene, JointPosition.name)
    blocks = blocks_on_the_way(asked, solved(asked))
    assert blocks[0].subjects == ("joint positions",)
    known = Explanation(
        problem=asked,
        status=Status.STUCK,
        reason="",
        certainty=Certainty.EVIDENCE,
        grounds="",
        blocks=blocks[:1],
    )
    assert not list(candidates(known))


def test_a_single_colliding_configuration_is_reported_as_one(scene: to.Scene) -> None:
    problem = to.Problem(scene=scene, start=START, goal=GOAL)
    here = np.zeros(2)
    blocked = GoalCandidates((), (here,), ("arm", "wall", -0.01), here, 0.0)
    assert no_goal_configuration(problem.reduced, blocked, ()) == (
        "the one configuration found that reaches the goal collides: arm is 10.0 mm inside wall"
    )
    near = GoalCandidates((), (here, here), ("arm", "wall", 0.01), here, 0.0, required=0.02)
    assert no_goal_configuration(problem.reduced, near, ()).startswith(
        "all 2 configurations found that reach the goal collide or come too near to something; in the nearest"
    )
