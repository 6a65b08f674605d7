"""Forms of a rotation, against scipy and against each other."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from trajopt.values.placement import as_quaternion, as_rpy, from_quaternion, from_rpy

RNG = np.random.default_rng(5)


@pytest.mark.parametrize("turn", [Rotation.random(rng=RNG) for _ in range(50)])
def test_forms_are_those_of_scipy(turn: Rotation) -> None:
    matrix = turn.as_matrix()
    assert as_quaternion(matrix) == pytest.approx(turn.as_quat(canonical=True), abs=1e-12)
    assert as_rpy(matrix) == pytest.approx(turn.as_euler("xyz"), abs=1e-12)
    assert from_quaternion(*turn.as_quat().tolist()) == pytest.approx(matrix, abs=1e-12)
    assert from_rpy(*turn.as_euler("xyz").tolist()) == pytest.approx(matrix, abs=1e-12)


@pytest.mark.parametrize("roll", [-3.0, 0.0, 0.4])
@pytest.mark.parametrize("pitch", [-np.pi / 2, 0.0, np.pi / 2])
@pytest.mark.parametrize("yaw", [-np.pi, -1.0, 0.0, np.pi / 2])
def test_forms_lead_back(roll: float, pitch: float, yaw: float) -> None:
    matrix = from_rpy(roll, pitch, yaw)
    assert from_rpy(*as_rpy(matrix)) == pytest.approx(matrix, abs=1e-12)
    assert from_quaternion(*as_quaternion(matrix).tolist()) == pytest.approx(matrix, abs=1e-12)


def test_no_rotation_is_exact() -> None:
    assert np.array_equal(from_quaternion(0.0, 0.0, 0.0, 1.0), np.eye(3))
    assert np.array_equal(from_rpy(0.0, 0.0, 0.0), np.eye(3))
