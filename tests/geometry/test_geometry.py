"""Coal's geometries are made once for each shape."""

import coal
import numpy as np
import pytest

from tests.values.test_mesh_file import box
from trajopt.geometry.geometry import collision_geometry
from trajopt.values.arrays import Floats
from trajopt.values.shapes.shapes import MOST_NEIGHBOURS, Box, Sphere, convex
from trajopt.verify.kernel.shapes import coal_geometry


@pytest.mark.parametrize("shape", [Box(1, 2, 3), box(0.1, 0.2, 0.3), convex(box(0.1, 0.2, 0.3).vertices)])
def test_one_geometry_a_shape(shape: object) -> None:
    assert collision_geometry(shape) is collision_geometry(shape)  # pyright: ignore[reportArgumentType]


def test_equal_shapes_stay_equal() -> None:
    one, other = Sphere(0.1), Sphere(0.1)
    geometry = collision_geometry(one)
    assert (one, hash(one), repr(one)) == (other, hash(other), repr(other))
    assert collision_geometry(other) is not geometry
    assert collision_geometry(Sphere(0.2)).radius == 0.2  # pyright: ignore


def _ring(count: int, radius: float, height: float) -> Floats:
    angles = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return np.stack((radius * np.cos(angles), radius * np.sin(angles), np.full(count, height)), axis=1)


@pytest.mark.parametrize(
    "points",
    [
        np.concatenate((_ring(400, 0.05, 0.0), _ring(400, 0.05, 0.02))),
        np.concatenate((_ring(1500, 0.05, 0.0), [[0.0, 0.0, 0.1]])),
        np.concatenate((_ring(600, 5.0, 0.0), [[0.0, 0.0, 0.1], [0.0, 0.0, -3.0]])),
        np.concatenate(
            [_ring(360, 1e-3 * r, 1e-3 * np.sqrt(1.0 - r * r)) for r in (0.2, 0.7, 1.0)] + [[[0, 0, 1e-3]]]
        ),
    ],
    ids=["flat faces", "cone", "two tips", "small"],
)
def test_hulls_with_corners_of_many_neighbours(points: Floats) -> None:
    hull = convex(points)
    rng = np.random.default_rng(5)
    directions = rng.normal(size=(500, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    grown = (directions @ hull.vertices.T).max(axis=1) - (directions @ points.T).max(axis=1)
    assert grown.min() >= 0.0
    assert grown.max() < 5e-7
    assert np.array_equal(convex(hull.vertices).vertices, hull.vertices)
    for geometry in (collision_geometry(hull), coal_geometry(hull)):
        assert isinstance(geometry, coal.ConvexBase)


@pytest.mark.parametrize(("size", "away"), [(1e5, 0.0), (1.0, 1e5), (1e-4, 0.0)])
def test_hulls_of_any_size_end(size: float, away: float) -> None:
    tip = np.concatenate((_ring(400, size, 0.0), [[0.0, 0.0, size]])) + np.array((away, 0.0, 0.0))
    hull = convex(tip)
    assert np.bincount(hull.faces.ravel()).max() <= MOST_NEIGHBOURS
