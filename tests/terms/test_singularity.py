"""Singular values against closed forms and against Jacobians by finite differences."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt import terms
from trajopt.arrays import Floats
from trajopt.errors import ProblemError
from trajopt.model.reduced import ReducedModel, reduce_model
from trajopt.query import Query
from trajopt.terms.motion import Motion
from trajopt.terms.singularity_distance import SmallestSingularValue

positions = st.tuples(st.floats(-6, 6), st.floats(0, 0.3), st.floats(-2.5, 2.5), st.floats(-3, 3))
OFFSET = np.array((0.05, 0.0, 0.02))


@pytest.fixture(scope="module")
def reduced(tmp_path_factory: pytest.TempPathFactory) -> ReducedModel:
    robot = odd_arm(tmp_path_factory.mktemp("robot"))
    return reduce_model(to.Scene(robot), "all", robot.positions())


def differenced(reduced: ReducedModel, at: Floats, length: float) -> Floats:
    """The finger's Jacobian by central differences of its placement."""
    step, columns = 1e-6, []
    for joint in np.eye(len(at)):
        high, low = (
            reduced.scene.placement_of("finger", reduced.all_positions(at + sign * step * joint))
            for sign in (1.0, -1.0)
        )
        spin = (high.rotation - low.rotation) @ ((high.rotation + low.rotation) / 2).T / (2 * step)
        angular = np.array((spin[2, 1], spin[0, 2], spin[1, 0]))
        columns.append(np.append((high * OFFSET - low * OFFSET) / (2 * step), length * angular))
    return np.array(columns).T


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(at=positions)
def test_singular_values_are_those_of_the_jacobian(reduced: ReducedModel, at: tuple[float, ...]) -> None:
    motion = Motion.single(np.array(at), Query(reduced))
    expected = np.linalg.svd(differenced(reduced, np.array(at), 0.3), compute_uv=False)
    need = to.singularity_distance("finger", 0.01, length=0.3, offset=OFFSET)
    found = SmallestSingularValue(reduced, need).linearise(motion).value[0]
    assert found == pytest.approx(expected[-1], abs=1e-6)
    at_origin = terms.LostManipulability("finger", 0.01, 0.3).linearise(motion).value[0]
    origin = to.singularity_distance("finger", 0.01, length=0.3)
    jacobian = terms.frame_jacobian.frame_jacobian(
        reduced, motion, "finger", length=origin.length, offset=origin.offset
    ).matrix[0]
    volume = float(np.sqrt(max(np.linalg.det(jacobian.T @ jacobian), 0.0)))
    assert at_origin == pytest.approx(0.01 / (0.01 + volume), abs=1e-6)


def test_two_rods_by_hand() -> None:
    """The product of both singular values is the area that the columns span, none when stretched."""
    robot = to.load("planar2")
    group = next(iter(robot.groups))
    reduced = reduce_model(to.Scene(robot), group, robot.positions())
    frame = robot.links[-1]
    for elbow in (0.0, 0.4, 1.5):
        motion = Motion.single(np.array((0.3, elbow)), Query(reduced))
        matrix = terms.frame_jacobian.frame_jacobian(
            reduced, motion, frame, length=0.0, offset=np.zeros(3)
        ).matrix[0]
        assert np.linalg.svd(matrix, compute_uv=False).prod() == pytest.approx(
            np.linalg.norm(np.cross(matrix[:, 0], matrix[:, 1])), abs=1e-12
        )
        if elbow == 0.0:
            assert np.linalg.svd(matrix, compute_uv=False)[-1] == pytest.approx(0.0, abs=1e-12)


def test_bad_input_is_refused() -> None:
    with pytest.raises(ProblemError, match="smallest"):
        to.singularity_distance("tip", 0.0)
    with pytest.raises(ProblemError, match="length"):
        to.singularity_distance("tip", 0.1, length=-1.0)
