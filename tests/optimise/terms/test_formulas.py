"""Residuals against independent formulas."""

from time import process_time

import numpy as np
import pytest
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.geometry import Query
from trajopt.optimise import terms
from trajopt.optimise.terms.frame_placement import rotation_vector
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


def test_rotation_vectors_of_half_turns_are_exact_and_as_fast_as_others() -> None:
    rng = np.random.default_rng(0)
    axes = np.vstack((np.eye(3), -np.eye(3), rng.normal(size=(4000, 3))))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    seconds: dict[str, float] = {}
    for name, short in (("others", 1.0), ("near", 1e-5), ("half", 0.0)):
        angles = np.pi - short * rng.uniform(0.5, 1.0, len(axes))
        turned = Rotation.from_rotvec(axes * angles[:, None]).as_matrix()
        rotation_vector(turned)
        began = process_time()
        vectors, _ = rotation_vector(turned)
        seconds[name] = process_time() - began
        assert Rotation.from_rotvec(vectors).as_matrix() == pytest.approx(turned, abs=1e-9)
        if short:
            assert vectors == pytest.approx(axes * angles[:, None], abs=1e-9)
    assert max(seconds["near"], seconds["half"]) < 5.0 * seconds["others"]
