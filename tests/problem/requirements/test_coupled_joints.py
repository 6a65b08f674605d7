"""Sums of joints: term and judge, with joints that mimic or stand still, and what every kind is asked."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trajopt as to
import trajopt.optimise.terms
from tests.problem.requirements.kind import Kind
from tests.robots_for_tests import two_arms
from tests.verify.arms import mixed_arm, quintic, reduced
from trajopt.geometry import Query
from trajopt.optimise import terms
from trajopt.optimise.terms.joint_positions import JointSum
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import CoupledJoints, coupled_joints
from trajopt.problem.residual import WHOLE
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.errors import ProblemError
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Check, Evidence, VerifyOptions, When, check_requirement
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import JudgedMotion

number = st.floats(-2.0, 2.0)


@settings(max_examples=60, deadline=None)
@given(at=st.tuples(number, number, number, number), factors=st.tuples(number, number, number))
def test_a_sum_of_joints(
    odd: ReducedModel, at: tuple[float, ...], factors: tuple[float, float, float]
) -> None:
    names = ("pan", "wrist", "follow")
    if not any(factors):
        return
    need = to.coupled_joints(dict(zip(names, factors, strict=True)), 0.4, tolerance=0.1)
    full = odd.all_positions(np.array(at))
    expected = sum(
        factor * full[odd.scene.robot.joint_names.index(name)]
        for name, factor in zip(names, factors, strict=True)
    )
    found = terms.constrain(need, odd, WHOLE)
    motion = Motion.single(np.array(at), Query(odd))
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


def judged(model: ReducedModel, there: Trajectory, when: When, tolerance: float) -> Check:
    motion = JudgedMotion(model, there, kinematics=Kinematics(model), options=VerifyOptions())
    wanted = coupled_joints({"j1": 1.0, "j4": -1.0, "j5": 2.0}, 0.2, tolerance=tolerance)
    (found,) = check_requirement(wanted, motion, when)
    return found


def test_the_extreme_between_points_is_exact(tmp_path: Path) -> None:
    """With j5 = 0.1 - j4 / 2 the sum is j1 - 2 j4 + 0.2: it leaves its value by j1 - 2 j4."""
    model = reduced(Scene(mixed_arm(tmp_path)), [0.0, 0.0, 0.0, 0.0])
    there = quintic(model, [[0.0] * 4, [0.9, 0.5, 0.1, 0.2], [0.0] * 4], 1.0)
    assert judged(model, there, When.END, 1e-3).holds
    found = judged(model, there, When.ALWAYS, 0.501)
    assert found.holds
    assert found.evidence is Evidence.PROVEN
    assert found.value == pytest.approx(0.5)
    assert found.time == pytest.approx(0.5, abs=1e-3)
    assert not judged(model, there, When.ALWAYS, 0.499).holds


KIND = Kind(
    requirement=CoupledJoints,
    printed=[
        (
            to.coupled_joints({"a": 1.0, "b": -1.0, "c": 0.5}, tolerance=0.01),
            "a - b + 0.5 c = 0, within 0.01",
        )
    ],
    relaxed=[to.coupled_joints({"elbow": 1.0, "wrist": -1.0}, tolerance=0.1)],
    residuals={JointSum: [lambda _: JointSum(np.array([0.5, 0.0, -1.0, 2.0]), 0.3)]},
    calls={
        "coupled_joints": {
            "weights": {"panda_joint1": 1.0, "panda_joint2": -1.0},
            "value": 0.1,
            "tolerance": 0.1,
        }
    },
)
