import numpy as np
import pytest

import trajopt as to
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import (
    Box,
    Capsule,
    Cone,
    Cylinder,
    Plane,
    Shape,
    Sphere,
    bounding_box,
    convex,
)
from trajopt.values.shapes.surfaces import SECTORS, surface

FLATTENED = SECTORS / (2 * np.pi) * np.sin(2 * np.pi / SECTORS)
"""Area of the polygon that stands for a circle, as a share of the circle's."""

TETRAHEDRON = convex([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
VOLUMES: list[tuple[Shape, float, float]] = [
    (Box(0.1, 0.2, 0.3), 0.006, 1e-12),
    (TETRAHEDRON, 1 / 6, 1e-12),
    (Mesh(TETRAHEDRON.vertices, TETRAHEDRON.faces), 1 / 6, 1e-12),
    (Cylinder(0.1, 0.5), np.pi * 0.01 * 0.5 * FLATTENED, 1e-12),
    (Cone(0.1, 0.5), np.pi * 0.01 * 0.5 / 3 * FLATTENED, 1e-12),
    (Sphere(0.1), np.pi * 4 / 3 * 1e-3, 0.02),
    (Capsule(0.1, 0.5), np.pi * (4 / 3 * 1e-3 + 0.005), 0.02),
    (to.Points([(0, 0, 0), (1, 0, 0)], radius=0.1), 2 * 4 / 3 * 1e-3, 1e-12),  # octahedra: there may be many
    (to.Voxels([(0, 0, 0), (2, 0, 0)], size=0.1), 2e-3, 1e-12),
]


def volume(shape: Shape) -> float:
    """Volume by the divergence theorem: right only if the surface is closed and points outward."""
    skin = surface(shape)
    corners = skin.vertices[skin.faces]
    return float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))) / 6


@pytest.mark.parametrize(("shape", "expected", "tolerance"), VOLUMES, ids=lambda v: type(v).__name__)
def test_surface_is_closed_and_outward(shape: Shape, expected: float, tolerance: float) -> None:
    assert volume(shape) == pytest.approx(expected, rel=tolerance)


@pytest.mark.parametrize("shape", [row[0] for row in VOLUMES], ids=lambda v: type(v).__name__)
def test_surface_fills_the_bounding_box(shape: Shape) -> None:
    vertices = surface(shape).vertices
    lower, upper = bounding_box(shape)
    np.testing.assert_allclose(vertices.min(axis=0), lower, atol=1e-12)
    np.testing.assert_allclose(vertices.max(axis=0), upper, atol=1e-12)


def test_every_shape_but_the_plane_is_covered() -> None:
    assert {type(row[0]) for row in VOLUMES} | {Plane} == set(to.values.shapes.shapes.Shape.__args__)


def test_the_plane_mesh_faces_up_and_lies_below_its_surface() -> None:
    skin = surface(Plane())
    corners = skin.vertices[skin.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (normals[:, 2] > 0.0).all()
    assert (skin.vertices[:, 2] < 0.0).all()
