"""Distances between shapes in MuJoCo equal those of Coal."""

import coal
import mujoco
import numpy as np
import pytest

from trajopt.simulation.dynamic_scene import CONE_TOLERANCE, mujoco_geoms
from trajopt.simulation.spec import add_geom
from trajopt.values.arrays import readonly
from trajopt.values.placement import Placement, placement
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Convex, Cylinder, Plane, Shape, Sphere, convex

WEDGE = convex([(0.3, 0.1, 0.1), (0.4, 0.1, 0.1), (0.3, 0.25, 0.1), (0.32, 0.12, 0.3), (0.38, 0.2, 0.2)])
"""Far from its own origin and axes: MuJoCo moves a mesh's frame to its centre of mass."""
SHAPES: dict[str, Shape] = {
    "box": Box(0.1, 0.2, 0.3),
    "sphere": Sphere(0.08),
    "cylinder": Cylinder(0.05, 0.3),
    "capsule": Capsule(0.05, 0.2),
    "cone": Cone(0.1, 0.25),
    "convex": WEDGE,
}


def in_coal(shape: Shape) -> coal.CollisionGeometry:
    if isinstance(shape, Convex):
        points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
        points.extend(list(shape.vertices))
        for a, b, c in shape.faces:
            triangles.append(coal.Triangle(int(a), int(b), int(c)))
        return coal.Convex(points, triangles)
    return {
        Box: lambda box: coal.Box(box.x, box.y, box.z),
        Sphere: lambda sphere: coal.Sphere(sphere.radius),
        Cylinder: lambda cylinder: coal.Cylinder(cylinder.radius, cylinder.length),
        Capsule: lambda capsule: coal.Capsule(capsule.radius, capsule.length),
        Cone: lambda cone: coal.Cone(cone.radius, cone.length),
        Plane: lambda _: coal.Halfspace(np.array((0.0, 0.0, 1.0)), 0.0),
    }[type(shape)](shape)


def coal_distance(a: Shape, at: Placement, b: Shape, bt: Placement) -> float:
    first, second = (coal.Transform3s(p.rotation, p.translation) for p in (at, bt))
    request = coal.DistanceRequest()
    request.gjk_tolerance = request.epa_tolerance = 1e-9
    return float(coal.distance(in_coal(a), first, in_coal(b), second, request, coal.DistanceResult()))


def mujoco_distance(a: Shape, at: Placement, b: Shape, bt: Placement) -> float:
    spec = mujoco.MjSpec()
    names: list[list[str]] = []
    for label, shape, where in (("a", a, at), ("b", b, bt)):
        parts, _ = mujoco_geoms(shape, moving=False)
        names.append([f"{label}{k}" for k in range(len(parts))])
        for name, piece in zip(names[-1], parts, strict=True):
            add_geom(spec, spec.worldbody, name, piece, where)
    model = spec.compile()
    state = mujoco.MjData(model)
    mujoco.mj_forward(model, state)
    return min(
        mujoco.mj_geomDistance(model, state, model.geom(i).id, model.geom(j).id, 10.0, None)
        for i in names[0]
        for j in names[1]
    )


@pytest.mark.parametrize("second", SHAPES)
@pytest.mark.parametrize("first", SHAPES)
def test_distance_between_shapes(first: str, second: str) -> None:
    rng = np.random.default_rng(3)
    for _ in range(3):
        at = placement(rng.uniform(-0.1, 0.1, 3), rpy=rng.uniform(-3, 3, 3))
        away = rng.normal(size=3)
        bt = placement(1.2 * away / np.linalg.norm(away), rpy=rng.uniform(-3, 3, 3))
        expected = coal_distance(SHAPES[first], at, SHAPES[second], bt)
        assert expected > 0.05
        assert mujoco_distance(SHAPES[first], at, SHAPES[second], bt) == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("name", SHAPES)
def test_distance_to_a_half_space(name: str) -> None:
    ground = placement((0.1, -0.2, -1.0), rpy=(0.4, -0.3, 1.0))
    where = placement((0.2, 0.1, 0.3), rpy=(1.0, 0.5, -2.0))
    expected = coal_distance(Plane(), ground, SHAPES[name], where)
    assert mujoco_distance(Plane(), ground, SHAPES[name], where) == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("depth", [0.01, 0.03])
def test_depth_of_penetration(depth: float) -> None:
    at, bt = placement(), placement((0.0, 0.0, 0.15 + 0.08 - depth))
    assert mujoco_distance(SHAPES["box"], at, SHAPES["sphere"], bt) == pytest.approx(-depth, abs=1e-6)


def test_moving_half_space_is_a_large_box_with_a_note() -> None:
    (piece,), note = mujoco_geoms(Plane(), moving=True)
    assert piece.kind == mujoco.mjtGeom.mjGEOM_BOX
    assert "box" in note
    top = piece.placement.translation[2] + piece.size[2]
    assert top == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("radius", [0.002, 0.05, 0.13])
def test_pyramid_contains_its_cone_tightly_with_a_note(radius: float) -> None:
    (piece,), note = mujoco_geoms(Cone(radius, 0.2), moving=True)
    base = piece.vertices[piece.vertices[:, 2] < 0.0]
    outer = np.linalg.norm(base[:, :2], axis=1).max()
    middle = np.linalg.norm((base[0] + base[np.argsort(np.linalg.norm(base - base[0], axis=1))[1]])[:2]) / 2
    assert middle >= radius * (1.0 - 1e-12)
    assert outer - radius <= CONE_TOLERANCE * 1.05
    assert "pyramid" in note


def test_exact_mesh_becomes_convex_geoms_with_a_note() -> None:
    box = convex([(x, y, z) for x in (0.0, 0.2) for y in (0.0, 0.1) for z in (0.0, 0.3)])
    mesh = Mesh(readonly(np.array(box.vertices)), np.array(box.faces))
    parts, note = mujoco_geoms(mesh, moving=True)
    assert len(parts) >= 1
    assert note.startswith("the exact mesh is simulated by a cover that contains it")
    at, bt = placement(), placement((0.5, 0.05, 0.15))
    assert mujoco_distance(mesh, at, Sphere(0.1), bt) == pytest.approx(0.2, abs=1e-5)
