"""Terms of joints: sums, with joints that mimic or stand still, and the cost of leaving a posture."""

import numpy as np
import pytest
from hypothesis import strategies as st

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.geometry import Query
from trajopt.optimise import terms
from trajopt.problem.motion import Motion
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.errors import JointNotFound, ProblemError

number = st.floats(-2.0, 2.0)


@pytest.fixture(scope="module")
def reduced(tmp_path_factory: pytest.TempPathFactory) -> ReducedModel:
    robot = odd_arm(tmp_path_factory.mktemp("robot"))
    return reduce_model(to.Scene(robot), "all", robot.positions())


def test_a_posture_draws_the_middle_of_a_motion() -> None:
    robot = to.load("planar2")
    names = robot.groups[next(iter(robot.groups))].joints
    start, goal = dict.fromkeys(names, 0.0), {names[0]: 1.0, names[1]: 0.0}

    def middle(*costs: terms.Cost) -> float:
        problem = to.Problem(
            scene=to.Scene(robot),
            start=start,
            goal=to.joint_positions(goal),
            costs=(*(terms.Cost(term) for term in (terms.Velocity(), terms.Acceleration())), *costs),
        )
        return float(to.plan(problem).require().path.knots[problem.knots // 2, 1])

    assert middle() == pytest.approx(0.0, abs=1e-3)
    assert middle(terms.rest_posture({names[1]: 0.6}, weight=1e-2)) > 0.2


def test_a_posture_of_other_joints_is_refused(reduced: ReducedModel) -> None:
    cost = terms.rest_posture({"elbov": 0.1})
    with pytest.raises(JointNotFound, match="elbow"):
        cost.residual.linearise(Motion.single(np.zeros(4), Query(reduced)))
    with pytest.raises(ProblemError, match="at least one"):
        terms.rest_posture({})
