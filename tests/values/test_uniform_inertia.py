"""Inertia of filled shapes, against sums over the small cubes that a shape consists of."""

from collections.abc import Callable

import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from trajopt.scene.scene_object import uniform_inertia
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Shape, bounding_box, convex

CUBES = 80
"""Along the longest edge of a shape's box."""
CORNERS = np.array([[x, y, z] for x in (-0.1, 0.3) for y in (0.0, 0.2) for z in (-0.5, 0.1)])
WEDGE = np.array([[0, 0, 0], [0.4, 0, 0], [0, 0.3, 0], [0, 0, 0.2], [0.4, 0, 0.2], [0, 0.3, 0.2]])

Inside = Callable[[np.ndarray], np.ndarray]
SHAPES: list[tuple[Shape, Inside]] = [
    (to.Box(0.1, 0.2, 0.4), lambda p: np.ones(len(p), dtype=bool)),
    (to.Sphere(0.3), lambda p: np.linalg.norm(p, axis=1) <= 0.3),
    (to.Cylinder(0.1, 0.5), lambda p: np.hypot(p[:, 0], p[:, 1]) <= 0.1),
    (
        to.Capsule(0.1, 0.3),
        lambda p: np.hypot(np.hypot(p[:, 0], p[:, 1]), np.maximum(np.abs(p[:, 2]) - 0.15, 0.0)) <= 0.1,
    ),
    (to.Cone(0.2, 0.5), lambda p: np.hypot(p[:, 0], p[:, 1]) <= 0.2 * (0.25 - p[:, 2]) / 0.5),
    (convex(WEDGE), lambda p: p[:, 0] / 0.4 + p[:, 1] / 0.3 <= 1.0),
]


def summed(shape: Shape, inside: Inside) -> pin.Inertia:
    lower, upper = bounding_box(shape)
    edge = (upper - lower).max() / CUBES
    axes = [np.arange(low + edge / 2.0, high, edge) for low, high in zip(lower, upper, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    points = points[inside(points)]
    centre = points.mean(axis=0)
    away = points - centre
    moments = np.einsum("ni,ni->", away, away) * np.eye(3) - away.T @ away
    return pin.Inertia(len(points) * edge**3, centre, edge**3 * moments)


def same(one: pin.Inertia, other: pin.Inertia, share: float) -> None:
    """Compare masses, centres and moments, by a share of the largest."""
    assert one.mass == pytest.approx(other.mass, rel=share)
    size = np.sqrt(np.trace(other.inertia) / other.mass)
    assert one.lever == pytest.approx(other.lever, abs=share * size)
    assert one.inertia == pytest.approx(other.inertia, abs=share * np.abs(other.inertia).max())


@pytest.mark.parametrize(("shape", "inside"), SHAPES, ids=lambda item: type(item).__name__)
def test_shapes_are_filled_evenly(shape: Shape, inside: Inside) -> None:
    same(uniform_inertia(shape), summed(shape, inside), share=0.03)


def test_hulls_of_points_and_meshes_are_the_solid_itself() -> None:
    box = pin.SE3(np.eye(3), np.array((0.1, 0.1, -0.2))).act(uniform_inertia(to.Box(0.4, 0.2, 0.6)))
    hull = convex(CORNERS)
    same(uniform_inertia(hull), box, share=1e-12)
    open_below = Mesh(hull.vertices, hull.faces[:-2])
    same(uniform_inertia(open_below), box, share=1e-12)


def test_a_mesh_in_a_plane_is_a_plate() -> None:
    plate = Mesh(
        np.array([[0, 0, 1], [0.4, 0, 1], [0.4, 0.2, 1], [0, 0.2, 1.0]]), np.array([[0, 1, 2], [0, 2, 3]])
    )
    found = uniform_inertia(plate)
    assert found.lever == pytest.approx([0.2, 0.1, 1.0])
    assert np.diag(found.inertia) / found.mass == pytest.approx(
        [0.2**2 / 12, 0.4**2 / 12, (0.2**2 + 0.4**2) / 12]
    )


def test_clouds_are_their_balls_and_cubes() -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.5]])
    balls = pin.Inertia.Zero()
    for point in points:
        balls += pin.SE3(np.eye(3), point).act(uniform_inertia(to.Sphere(0.1)))
    same(uniform_inertia(to.Points(points, 0.1)), balls, share=1e-12)
    keys = np.array([[x, y, z] for x in range(2) for y in range(3) for z in range(4)])
    whole = pin.SE3(np.eye(3), np.array((0.1, 0.15, 0.2))).act(uniform_inertia(to.Box(0.2, 0.3, 0.4)))
    same(uniform_inertia(to.Voxels(keys, 0.1)), whole, share=1e-12)


def test_objects_of_several_shapes_are_as_heavy_as_they_say() -> None:
    halves = [(to.Box(0.1, 0.1, 0.2), to.placement((0, 0, z))) for z in (0.1, 0.3)]
    scene = to.Scene(to.load("planar2")).add("bar", halves, to.placement((5, 0, 0)), mass=3.0)
    whole = pin.SE3(np.eye(3), np.array((0, 0, 0.2))).act(pin.Inertia.FromBox(3.0, 0.1, 0.1, 0.4))
    same(scene.object("bar").inertia, whole, share=1e-12)
    tilted = scene.add("frame", [], to.placement((1, 0, 0)), mass=2.0).object("frame").inertia
    assert tilted.mass == 2.0 and not tilted.lever.any() and not tilted.inertia.any()
