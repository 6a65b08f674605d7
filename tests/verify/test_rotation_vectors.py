"""The judge's rotation vectors against SciPy's."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from trajopt.verify.checks.frames import rotation_vectors


@pytest.mark.parametrize(
    "angle", [0.0, 1e-12, 1e-7, 1e-3, 1.0, np.pi / 2, 2.0, 3.1, np.pi - 1e-5, np.pi - 1e-9]
)
def test_they_are_those_of_scipy(angle: float) -> None:
    axes = np.vstack((np.eye(3), -np.eye(3), np.random.default_rng(1).normal(size=(200, 3))))
    vectors = angle * axes / np.linalg.norm(axes, axis=1)[:, None]
    found = rotation_vectors(Rotation.from_rotvec(vectors).as_matrix())
    np.testing.assert_allclose(found, vectors, rtol=0.0, atol=1e-9)


def test_half_a_turn_has_either_sign() -> None:
    axes = np.vstack((np.eye(3), np.random.default_rng(2).normal(size=(200, 3))))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    found = rotation_vectors(2.0 * axes[:, :, None] * axes[:, None, :] - np.eye(3))
    size = np.abs((found * axes).sum(axis=1))
    np.testing.assert_allclose(size, np.pi, rtol=1e-7)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), np.pi, rtol=1e-7)
