"""Terms of joints: sums, with joints that mimic or stand still, and the cost of leaving a posture."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trajopt as to
from tests.robots_for_tests import odd_arm, two_arms
from trajopt import terms
from trajopt.errors import JointNotFound, ProblemError
from trajopt.model.reduced import ReducedModel, reduce_model
from trajopt.query import Query
from trajopt.terms.motion import Motion
from trajopt.terms.residual import WHOLE

number = st.floats(-2.0, 2.0)


@pytest.fixture(scope="module")
def reduced(tmp_path_factory: pytest.TempPathFactory) -> ReducedModel:
    robot = odd_arm(tmp_path_factory.mktemp("robot"))
    return reduce_model(to.Scene(robot), "all", robot.positions())


@settings(max_examples=60, deadline=None)
@given(at=st.tuples(number, number, number, number), factors=st.tuples(number, number, number))
def test_a_sum_of_joints(
    reduced: ReducedModel, at: tuple[float, ...], factors: tuple[float, float, float]
) -> None:
    names = ("pan", "wrist", "follow")
    if not any(factors):
        return
    need = to.coupled_joints(dict(zip(names, factors, strict=True)), 0.4, tolerance=0.1)
    full = reduced.all_positions(np.array(at))
    expected = sum(
        factor * full[reduced.scene.robot.joint_names.index(name)]
        for name, factor in zip(names, factors, strict=True)
    )
    found = terms.constrain(need, reduced, WHOLE)
    motion = Motion.single(np.array(at), Query(reduced))
    for item in found:
        assert item.residual.linearise(motion).value[0] == pytest.approx(expected, abs=1e-12)
        assert (item.lower[0], item.upper[0]) == pytest.approx((0.31, 0.49))


def test_joints_outside_the_group_stand_still(tmp_path: Path) -> None:
    robot = two_arms(tmp_path)
    start = robot.positions({"right_elbow": 0.5})
    reduced = reduce_model(to.Scene(robot), "left", start)
    equal = to.coupled_joints({"left_elbow": 1.0, "right_elbow": -1.0}, tolerance=0.01)
    (item,) = terms.constrain(equal, reduced, WHOLE)
    at = Motion.single(np.array((0.1, 0.7)), Query(reduced))
    assert item.residual.linearise(at).value[0] == pytest.approx(0.2)
    still = to.coupled_joints({"right_elbow": 1.0}, 0.5, tolerance=0.01)
    assert terms.constrain(still, reduced, WHOLE) == ()
    with pytest.raises(ProblemError, match="right_elbow"):
        terms.constrain(to.coupled_joints({"right_elbow": 1.0}, tolerance=0.01), reduced, WHOLE)
    with pytest.raises(ProblemError, match="factor"):
        to.coupled_joints({}, tolerance=0.01)


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
