"""Coal's geometries are made once for each shape."""

import pytest

from tests.values.test_mesh_file import box
from trajopt.geometry.geometry import collision_geometry
from trajopt.values.shapes.shapes import Box, Sphere, convex


@pytest.mark.parametrize("shape", [Box(1, 2, 3), box(0.1, 0.2, 0.3), convex(box(0.1, 0.2, 0.3).vertices)])
def test_one_geometry_a_shape(shape: object) -> None:
    assert collision_geometry(shape) is collision_geometry(shape)  # pyright: ignore[reportArgumentType]


def test_equal_shapes_stay_equal() -> None:
    one, other = Sphere(0.1), Sphere(0.1)
    geometry = collision_geometry(one)
    assert (one, hash(one), repr(one)) == (other, hash(other), repr(other))
    assert collision_geometry(other) is not geometry
    assert collision_geometry(Sphere(0.2)).radius == 0.2  # pyright: ignore
