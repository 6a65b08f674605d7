"""Residuals against independent formulas."""

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

angles = st.floats(-1.4, 1.4)
positions = st.tuples(st.floats(-6, 6), st.floats(0, 0.3), st.floats(-2.5, 2.5), st.floats(-3, 3))


@pytest.fixture(scope="module")
def reduced(tmp_path_factory: pytest.TempPathFactory) -> ReducedModel:
    robot = odd_arm(tmp_path_factory.mktemp("robot"))
    return reduce_model(to.Scene(robot), "all", robot.positions())


def standing(reduced: ReducedModel, at: tuple[float, ...]) -> Motion:
    return Motion.single(np.array(at), Query(reduced))


def test_mimic_joint_moves_with_its_source(reduced: ReducedModel) -> None:
    at = np.array([0.0, 0.1, 0.2, 0.8])
    full = reduced.all_positions(at)
    names = reduced.scene.robot.joint_names
    assert full[names.index("follow")] == pytest.approx(-0.5 * 0.8 + 0.2)
    kinematics = Query(reduced).kinematics(at[None])
    joint, held = reduced.attachment("finger")
    expected = reduced.scene.placement_of("finger", full)
    found = kinematics.rotation[0, joint] @ held.translation + kinematics.translation[0, joint]
    assert found == pytest.approx(expected.translation, abs=1e-12)


@pytest.mark.parametrize(
    ("term", "order"), [(terms.Velocity(), 1), (terms.Acceleration(), 2), (terms.Jerk(), 3)]
)
def test_differences(reduced: ReducedModel, term: terms.Residual, order: int) -> None:
    knots = np.random.default_rng(0).normal(size=(6, 4))
    motion = Motion.through(knots, np.ones(5, dtype=np.int64), Query(reduced))
    assert term.linearise(motion).value == pytest.approx(np.diff(knots, n=order, axis=0).ravel())
