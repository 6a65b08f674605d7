"""Residuals against independent formulas."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt import terms
from trajopt.model.reduced import ReducedModel, reduce_model
from trajopt.model.requirements import RotationCoordinates
from trajopt.query import Query
from trajopt.terms.axis_alignment import AxisAngle
from trajopt.terms.frame_placement import FramePlacementError
from trajopt.terms.motion import Motion

angles = st.floats(-1.4, 1.4)
positions = st.tuples(st.floats(-6, 6), st.floats(0, 0.3), st.floats(-2.5, 2.5), st.floats(-3, 3))


@pytest.fixture(scope="module")
def reduced(tmp_path_factory: pytest.TempPathFactory) -> ReducedModel:
    robot = odd_arm(tmp_path_factory.mktemp("robot"))
    return reduce_model(to.Scene(robot), "all", robot.positions())


def standing(reduced: ReducedModel, at: tuple[float, ...]) -> Motion:
    return Motion.single(np.array(at), Query(reduced))


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(at=positions, rpy=st.tuples(angles, angles, angles))
def test_placement_error_rebuilds_the_frame(
    reduced: ReducedModel, at: tuple[float, ...], rpy: tuple[float, ...]
) -> None:
    """Composing the goal with the error must give the frame back, in both coordinates."""
    goal = to.placement((0.2, -0.1, 0.4), rpy=rpy)
    frame = reduced.scene.placement_of("tip", reduced.all_positions(np.array(at)))
    for coordinates in RotationCoordinates:
        required = to.frame_placement("tip", goal, coordinates=coordinates)
        value = FramePlacementError(reduced, required).linearise(standing(reduced, at)).value
        error = (
            Rotation.from_rotvec(value[3:])
            if coordinates is RotationCoordinates.ROTATION_VECTOR
            else Rotation.from_euler("XYZ", value[3:])
        )
        assert goal.rotation @ error.as_matrix() == pytest.approx(frame.rotation, abs=1e-7)
        assert goal.translation + goal.rotation @ value[:3] == pytest.approx(frame.translation, abs=1e-9)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(at=positions)
def test_tilt_is_the_angle(reduced: ReducedModel, at: tuple[float, ...]) -> None:
    required = to.axis_alignment("tip", axis=(0, 1, 1), direction=(1, 0, 2), tolerance=0.2)
    value = AxisAngle(reduced, required).linearise(standing(reduced, at)).value[0]
    frame = reduced.scene.placement_of("tip", reduced.all_positions(np.array(at)))
    cosine = (frame.rotation @ required.axis) @ required.direction
    assert np.cos(value) == pytest.approx(cosine, abs=1e-9)
    assert 0.0 <= value <= np.pi


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
