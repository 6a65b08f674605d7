"""Signed distances of every pair of shape kinds, against closed forms and an independent maximum.

The signed distance of convex bodies is the largest gap that any direction shows between them.
"""

from itertools import combinations_with_replacement
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.judge_distances import PlainDistances
from tests.oracles.judge_geometry import inside
from tests.verify.arms import joint, link, reduced, robot
from trajopt.robot.bodies import MeshPolicy
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.errors import ModelError
from trajopt.values.placement import Placement, placement
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Convex, Cylinder, Plane, Shape, Sphere, convex
from trajopt.values.shapes.surfaces import part_points
from trajopt.verify.checks.distances import support
from trajopt.verify.kernel.kinematics import Kinematics

ERROR = 1e-6
CLOUD = np.random.default_rng(3).normal(size=(30, 3)) * 0.08
SOLIDS: tuple[Shape, ...] = (
    Box(0.2, 0.3, 0.1),
    Sphere(0.1),
    Cylinder(0.08, 0.3),
    Capsule(0.06, 0.2),
    Cone(0.1, 0.25),
    convex(CLOUD),
)


def cube_mesh(size: float = 0.2) -> Mesh:
    corners = convex([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return Mesh(corners.vertices * size / 2, corners.faces)


def distance(folder: Path, first: Shape, second: Shape, where: Placement) -> float:
    """Distance with the first shape fixed in the world and the second on a link at `where`."""
    arm = robot(folder, link("base"), link("a"), joint("j", "base", "a"))
    scene = Scene(arm).add("fixed", first, meshes=MeshPolicy(exact=True))
    scene = scene.add("moved", second, where, frame="a", meshes=MeshPolicy(exact=True))
    model = reduced(scene, [0.0])
    distances = PlainDistances(model, error=ERROR)
    poses = Kinematics(model).poses(np.zeros((1, 1)))
    pair = next(p for p in range(len(distances.first)) if set(distances.owners(p)) == {"fixed", "moved"})
    found = distances.measure(poses, np.array([0]), np.array([pair]))[0]
    return float(found) + ERROR


def gap(first: Shape, second: Shape, where: Placement, directions: Floats) -> Floats:
    """Gap between the two along unit directions from the first to the second."""
    there = directions @ where.translation
    return there - support(first, directions) - support(second, -directions @ where.rotation)


def largest_gap(first: Shape, second: Shape, where: Placement, rng: np.random.Generator) -> float:
    """Largest gap that random search on the sphere of directions finds."""
    directions = rng.normal(size=(4_000, 3))
    spread = 1.0
    for _ in range(12):
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        gaps = gap(first, second, where, directions)
        best = directions[np.argsort(-gaps)[:8]]
        spread *= 0.25
        directions = np.vstack((best, (best[:, None] + spread * rng.normal(size=(8, 150, 3))).reshape(-1, 3)))
    return float(gaps.max())


@pytest.mark.parametrize(
    ("first", "second"),
    list(combinations_with_replacement(SOLIDS, 2)),
    ids=lambda shape: type(shape).__name__,
)
def test_signed_distance_is_the_largest_gap(tmp_path: Path, first: Shape, second: Shape) -> None:
    rng = np.random.default_rng(7)
    for reach in (0.03, 0.12, 0.45):
        direction = rng.normal(size=3)
        where = placement(
            reach * direction / np.linalg.norm(direction),
            rotation=Rotation.random(random_state=rng).as_matrix(),
        )
        for one, other, seen in ((first, second, where), (second, first, where.inverse())):
            found = distance(tmp_path, one, other, seen)
            lower = largest_gap(one, other, seen, rng)
            assert found >= lower - 1e-6, "the true distance is no smaller than any gap"
            assert found == pytest.approx(lower, abs=2e-4 if found < 0 else 2e-5)


@pytest.mark.parametrize(
    ("first", "second", "height", "expected"),
    [
        (Sphere(0.1), Sphere(0.2), 0.5, 0.2),
        (Sphere(0.1), Sphere(0.2), 0.25, -0.05),
        (Box(0.2, 0.2, 0.2), Box(0.4, 0.4, 0.4), 0.5, 0.2),
        (Box(0.2, 0.2, 0.2), Box(0.4, 0.4, 0.4), 0.27, -0.03),
        (Box(10.0, 10.0, 0.2), Sphere(0.05), 0.16, 0.01),
        (Cylinder(0.1, 0.4), Sphere(0.1), 0.4, 0.1),
        (Cylinder(0.1, 0.4), Cylinder(0.1, 0.2), 0.29, -0.01),
        (Capsule(0.1, 0.4), Sphere(0.1), 0.45, 0.05),
        (Capsule(0.1, 0.4), Capsule(0.1, 0.2), 0.49, -0.01),
        (Cone(0.1, 0.4), Sphere(0.1), 0.4, 0.1),
        (Cone(0.1, 0.4), Sphere(0.1), 0.29, -0.01),
        (Plane(), Sphere(0.1), 0.3, 0.2),
        (Plane(), Sphere(0.1), 0.05, -0.05),
        (Plane(), Box(0.1, 0.1, 0.4), 0.15, -0.05),
        (Plane(), Cylinder(0.1, 0.4), 0.25, 0.05),
        (Plane(), Capsule(0.1, 0.4), 0.25, -0.05),
        (Plane(), Cone(0.1, 0.4), 0.25, 0.05),
        (Plane(), cube_mesh(), 0.3, 0.2),
        (Plane(), cube_mesh(), 0.05, -0.05),
        (cube_mesh(), Sphere(0.1), 0.3, 0.1),
        (cube_mesh(), Box(0.1, 0.1, 0.1), 0.2, 0.05),
        (cube_mesh(), Capsule(0.05, 0.1), 0.3, 0.1),
        (cube_mesh(), Cone(0.05, 0.1), 0.3, 0.15),
        (cube_mesh(), Cylinder(0.05, 0.1), 0.3, 0.15),
        (cube_mesh(), cube_mesh(), 0.3, 0.1),
    ],
)
def test_closed_forms_along_z(
    tmp_path: Path, first: Shape, second: Shape, height: float, expected: float
) -> None:
    where = placement((0, 0, height))
    assert distance(tmp_path, first, second, where) == pytest.approx(expected, abs=3e-7)
    assert distance(tmp_path, second, first, where.inverse()) == pytest.approx(expected, abs=3e-7)


def test_a_tilted_half_space(tmp_path: Path) -> None:
    tilted = placement((0.0, 0.0, 0.5), rpy=(0.0, np.pi / 4, 0.0))
    found = distance(tmp_path, Plane(), Box(0.2, 0.1, 0.4), tilted)
    assert found == pytest.approx(0.5 - (0.1 + 0.2) / np.sqrt(2.0), abs=1e-9)


@pytest.mark.parametrize("shape", [*SOLIDS, cube_mesh(0.04)], ids=lambda shape: type(shape).__name__)
def test_contact_with_an_exact_mesh_is_never_positive(tmp_path: Path, shape: Shape) -> None:
    big = cube_mesh(0.9)
    assert distance(tmp_path, big, shape, placement((0.0, 0.0, 0.45))) < 0.0, "it crosses the surface"
    assert distance(tmp_path, big, shape, placement((0.1, 0.0, 0.0))) < -0.1, "it is wholly inside"
    assert distance(tmp_path, big, shape, placement((0.0, 0.0, 0.9))) > 0.0


def test_a_mesh_has_one_point_for_each_part_and_knows_its_inside() -> None:
    cube = cube_mesh(1.0)
    pair = Mesh(
        np.vstack((cube.vertices, cube.vertices + np.array((3.0, 0.0, 0.0)))),
        np.vstack((cube.faces, cube.faces + len(cube.vertices))),
    )
    assert len(part_points(pair)) == 2
    loose = Mesh(cube.vertices[cube.faces.reshape(-1)], np.arange(36).reshape(-1, 3))
    assert len(part_points(loose)) == 1, "corners that coincide are one"
    points = np.array([(0.0, 0.1, 0.2), (1.5, 0.0, 0.0), (3.2, 0.3, -0.4), (0.0, 0.0, 0.51)])
    assert inside(points, pair).tolist() == [True, False, True, False]
    assert len(part_points(SOLIDS[-1])) == 1
    assert isinstance(SOLIDS[-1], Convex)


def test_two_half_spaces_that_must_keep_apart_are_refused(tmp_path: Path) -> None:
    arm = robot(tmp_path, link("base"), link("a"), joint("j", "base", "a"))
    scene = Scene(arm).add("floor", Plane()).add("wall", Plane(), frame="a")
    with pytest.raises(ModelError, match="floor - wall"):
        PlainDistances(reduced(scene, [0.0]), error=ERROR)
    PlainDistances(reduced(scene.allow("floor", "wall"), [0.0]), error=ERROR)


def test_a_flat_mesh_can_be_measured(tmp_path: Path) -> None:
    square = Mesh(
        np.array([(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)]),
        np.array([(0, 1, 2), (0, 2, 3)]),
    )
    assert distance(tmp_path, square, Sphere(0.1), placement((0.2, 0.1, 0.3))) == pytest.approx(0.2, abs=1e-7)
    assert distance(tmp_path, square, Sphere(0.1), placement((0.2, 0.1, 0.05))) < 0.0
