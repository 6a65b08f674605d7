"""Generated grasps: the pads are where they must be, by geometry worked out apart."""

from dataclasses import replace

import coal
import numpy as np
import pytest

import trajopt as to
from trajopt.geometry.geometry import collision_geometry
from trajopt.tasks import PickObject
from trajopt.tasks.grasping import Grasp, Gripper, grasps_of, pallet
from trajopt.values.errors import ModelError, ProblemError, ShapeError
from trajopt.values.shapes.shapes import Shape

from .conftest import ANGLE, hexagonal, on_table


def grasps(robot: to.Robot, gripper: Gripper, shape: Shape) -> tuple[Grasp, ...]:
    return grasps_of(on_table(robot, shape, to.placement((0.5, 0.0, 0.1))), "thing", gripper)


def extent(shape: Shape, direction: np.ndarray) -> float:
    """How far a shape reaches along a direction from its centre, by sampling its surface."""
    rng = np.random.default_rng(1)
    match shape:
        case to.Box():
            points = rng.choice((-0.5, 0.5), (64, 3)) * (shape.x, shape.y, shape.z)
        case to.Cylinder():
            angle = np.linspace(0.0, 2.0 * np.pi, 721)
            ring = shape.radius * np.stack((np.cos(angle), np.sin(angle)), axis=1)
            points = np.vstack(
                [np.column_stack((ring, np.full(721, side * shape.length / 2))) for side in (-1, 1)]
            )
        case _:
            points = shape.radius * direction[None]
    return float((points @ direction).max())


@pytest.mark.parametrize(
    "shape",
    [to.Box(0.04, 0.05, 0.12), to.Cylinder(0.02, 0.1), to.Sphere(0.025)],
    ids=["box", "cylinder", "sphere"],
)
def test_pads_meet_the_shape_at_the_stated_width(panda: to.Robot, gripper: Gripper, shape: Shape) -> None:
    found = grasps(panda, gripper, shape)
    assert len({grasp.name for grasp in found}) == len(found) >= 16
    for grasp in found:
        approach = grasp.placement.rotation @ gripper.approach
        closing = grasp.placement.rotation @ gripper.closing
        assert grasp.width == pytest.approx(2.0 * extent(shape, closing), rel=1e-4)
        assert grasp.width < grasp.opening <= gripper.widest
        middle = grasp.placement.translation
        # Centred between the faces; over the edge by no more than the fingers reach.
        assert abs(middle @ closing) < 1e-12
        over = extent(shape, -approach) + middle @ approach
        assert 0.0 < over <= gripper.reach + 1e-9 < 0.0375, "the hand is 37.4 mm behind the pads' centres"
        np.testing.assert_allclose(np.cross(approach, middle), 0.0, atol=1e-12)


def test_a_weak_gripper_presses_with_its_largest_force(panda: to.Robot, gripper: Gripper) -> None:
    box = to.Box(0.04, 0.05, 0.12)
    for largest, expected in ((20.0, 20.0), (gripper.force, 30.0)):
        weak = replace(gripper, force=largest)
        assert {grasp.force for grasp in grasps(panda, weak, box)} == {expected}


def test_a_heavy_object_is_held_with_more_force(panda: to.Robot, gripper: Gripper) -> None:
    for mass, expected in ((0.2, 30.0), (2.5, 1.5 * 2.5 * 9.81), (40.0, gripper.force)):
        scene = on_table(panda, to.Box(0.04, 0.05, 0.12), to.placement((0.5, 0.0, 0.1)), mass)
        (force,) = {grasp.force for grasp in grasps_of(scene, "thing", gripper)}
        assert force == pytest.approx(expected)


def test_from_above_comes_first(panda: to.Robot, gripper: Gripper) -> None:
    first = grasps(panda, gripper, to.Box(0.04, 0.05, 0.12))[0]
    np.testing.assert_allclose(first.placement.rotation @ gripper.approach, (0.0, 0.0, -1.0), atol=1e-9)


def test_grasps_that_are_too_wide_are_omitted(panda: to.Robot, gripper: Gripper) -> None:
    found = grasps(panda, gripper, to.Box(0.2, 0.05, 0.3))
    assert {grasp.width for grasp in found} == {0.05}
    assert grasps(panda, gripper, to.Box(0.2, 0.2, 0.2)) == ()


def tube(outer: float, inner: float, length: float) -> to.Mesh:
    count = 48
    angles = 2.0 * np.pi / count * np.arange(count)
    ring = np.stack((np.cos(angles), np.sin(angles)), axis=1)
    profile = [(outer, -length / 2), (outer, length / 2), (inner, length / 2), (inner, -length / 2)]
    vertices = np.vstack([np.column_stack((radius * ring, np.full(count, z))) for radius, z in profile])
    here, there = np.arange(count), (np.arange(count) + 1) % count
    faces = [
        corners
        for low, high in ((0, 1), (1, 2), (2, 3), (3, 0))
        for corners in (
            np.stack((low * count + here, low * count + there, high * count + there), axis=1),
            np.stack((low * count + here, high * count + there, high * count + here), axis=1),
        )
    ]
    return to.Mesh(vertices, np.concatenate(faces))


EXACT = to.MeshPolicy(exact=True)


@pytest.mark.parametrize(
    ("shape", "meshes"),
    [
        (hexagonal(0.05, 0.1), None),
        (tube(0.035, 0.03, 0.1), EXACT),
        (tube(0.06, 0.055, 0.1), EXACT),
        (to.Capsule(0.025, 0.08), None),
        (to.Cone(0.025, 0.14), None),
        (ANGLE, None),
    ],
    ids=["hexagon", "tube", "wide tube", "capsule", "cone", "angle"],
)
def test_pads_close_on_opposite_sides_of_any_shape(
    panda: to.Robot, gripper: Gripper, shape: Shape, meshes: to.MeshPolicy | None
) -> None:
    """Coal measures two discs in the place of the pads: they touch the object, and are not in it."""
    scene = to.Scene(panda).add("thing", shape, meshes=meshes)
    found = grasps_of(scene, "thing", gripper)
    assert len({grasp.name for grasp in found}) == len(found) >= 12
    assert found[0].placement.rotation[2] @ gripper.approach < -0.9, "from above"
    for grasp in found:
        for sign in (-1.0, 1.0):
            for gap, expected in ((2e-4, False), (-4e-4, True)):
                off = (0.0, sign * (grasp.width / 2 + gap + 5e-4), 0.0)
                disc = grasp.placement * gripper.axes * to.placement(off, rpy=(np.pi / 2, 0.0, 0.0))
                assert disc_touches(scene, disc) is expected, (grasp, gap)


def disc_touches(scene: to.Scene, where: to.Placement) -> bool:
    def touch(shape: Shape, at: to.Placement) -> bool:
        there, solid = coal.Transform3s(at.rotation, at.translation), collision_geometry(shape)
        return bool(coal.collide(disc, here, solid, there, coal.CollisionRequest(), coal.CollisionResult()))

    disc, here = coal.Cylinder(5e-3, 1e-3), coal.Transform3s(where.rotation, where.translation)
    return any(touch(shape, at) for shape, at in scene.object("thing").parts)


def test_a_wide_tube_is_held_by_its_wall(panda: to.Robot, gripper: Gripper) -> None:
    scene = to.Scene(panda).add("thing", tube(0.06, 0.055, 0.1), meshes=EXACT)
    for grasp in grasps_of(scene, "thing", gripper):
        middle = grasp.placement * gripper.axes
        assert np.hypot(*middle.translation[:2]) == pytest.approx(0.0575, abs=1e-3)
        assert 0.005 <= grasp.width < 0.007


@pytest.mark.parametrize(
    "shape", [to.Cone(0.03, 0.03), to.Box(0.2, 0.2, 0.2)], ids=["flat cone", "large box"]
)
def test_without_opposite_sides_in_reach_there_is_no_grasp(
    panda: to.Robot, gripper: Gripper, shape: Shape
) -> None:
    assert grasps(panda, gripper, shape) == ()
    with pytest.raises(ProblemError, match="has no opposite sides"):
        PickObject("thing", grasps(panda, gripper, shape))


@pytest.mark.parametrize("shape", [to.Plane(), to.Points(np.zeros((1, 3)), 0.02)], ids=["plane", "points"])
def test_shapes_without_a_surface_to_hold_are_refused(
    panda: to.Robot, gripper: Gripper, shape: Shape
) -> None:
    with pytest.raises(ModelError, match=f"of a {type(shape).__name__} .object 'thing'"):
        grasps(panda, gripper, shape)


def test_a_frame_without_a_shape_is_refused(panda: to.Robot, gripper: Gripper) -> None:
    with pytest.raises(ModelError, match="'frame' has no shape"):
        grasps_of(to.Scene(panda).add("frame", []), "frame", gripper)


@pytest.mark.parametrize("staggered", [False, True])
def test_a_pallet_is_filled_from_below_and_from_the_far_side(staggered: bool) -> None:
    corner = to.placement((0.4, 0.1, 0.03), rpy=(0.0, 0.0, 0.3))
    places = pallet(corner, (3, 2, 2), (0.08, 0.07, 0.06), staggered=staggered)
    assert len(places) == 2 * (5 if staggered else 6)
    inside = np.array([(corner.inverse() * place).translation for place in places]) / (0.08, 0.07, 0.06)
    whole = {(x + 0.5 * staggered * y, y, z) for x in range(3 - staggered) for y in (1,) for z in (0, 1)}
    whole |= {(x, 0, z) for x in range(3) for z in (0, 1)}
    assert {tuple(row) for row in (inside.round(9) + 0.0).tolist()} == whole
    layers = inside[:, 2].round(9)
    assert (np.diff(layers) >= 0.0).all(), "no part is under one that is there"
    for layer in (0.0, 1.0):
        points = np.array([place.translation for place in places])[layers == layer]
        assert (np.diff(np.linalg.norm(points[:, :2], axis=1)) <= 1e-12).all(), "the near parts come last"


def test_a_pallet_without_places_is_refused() -> None:
    with pytest.raises(ShapeError, match="counts: must be positive, are"):
        pallet(to.placement(), (0, 1, 1), (0.1, 0.1, 0.1))
