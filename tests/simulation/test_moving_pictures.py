"""Pictures of dynamic obstacles: placements, presence, and halos."""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import coal
import numpy as np
import pytest
from scipy.spatial import ConvexHull

import trajopt as to
from tests.simulation.conftest import reduced_all, smooth
from tests.simulation.test_render import SIZE, opengl, pixels
from trajopt.geometry.geometry import collision_geometry
from trajopt.robot.robot import Robot
from trajopt.scene.reduced import ReducedModel
from trajopt.simulation import CameraView, Layout, render, simulate
from trajopt.simulation.camera import visible_points
from trajopt.simulation.halo import halo
from trajopt.simulation.picture_model import (
    HALO_GROUP,
    OBJECT_GROUP,
    ROBOT_GROUP,
    UNSEEN_GROUP,
    PosedModel,
    object_colours,
)
from trajopt.simulation.sampled_motion import motion_of
from trajopt.simulation.viewpoint import in_view
from trajopt.values.shapes.shapes import Shape, convex

__all__ = ["opengl"]
Pendulum = Callable[..., Robot]
SHAPES = (
    to.Box(0.2, 0.1, 0.3),
    to.Sphere(0.1),
    to.Cylinder(0.1, 0.2),
    to.Capsule(0.05, 0.2),
    to.Cone(0.1, 0.2),
    convex(np.random.default_rng(3).normal(size=(30, 3)) * 0.1),
)
HERE = to.placement((0.3, -0.2, 0.5), rpy=(0.3, 0.2, 1.0))
PASSES = to.Track.through(
    (0.0, 0.4), [to.placement((0.3, -0.3, 1.2)), to.placement((0.3, 0.3, 1.2), rpy=(0, 0, 1))]
)


def held(scene: to.Scene) -> tuple[ReducedModel, to.Trajectory]:
    """Hold the pendulum level for half a second."""
    reduced = reduced_all(scene)
    level = np.zeros(1)
    return reduced, smooth(reduced, level, level, 0.5)


def posed(scene: to.Scene) -> PosedModel:
    reduced, planned = held(scene)
    motion = motion_of(reduced, planned)
    return PosedModel(reduced, motion, in_view(reduced, motion))


def groups(picture: PosedModel, owner: str, time: float) -> set[int]:
    """Return the groups that the geometries of an object and its halo are in at a time."""
    picture.pose(time)
    halos = {geom for geom, (name, _) in picture._halos.items() if name == owner}
    own = {geom for geom, name in picture._coming.items() if name == owner} | halos
    return {int(picture.model.geom_group[geom]) for geom in own}


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
def test_halo_is_at_its_distance_from_the_shape(shape: Shape) -> None:
    around, dot = halo(shape, HERE), coal.Sphere(1e-9)
    there = coal.Transform3s(HERE.rotation, HERE.translation)
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    for point in around.grown(0.05):
        at = coal.Transform3s(np.eye(3), np.ascontiguousarray(point))
        result.clear()
        found = coal.distance(collision_geometry(shape), there, dot, at, request, result)
        assert found == pytest.approx(0.05, abs=2e-5)
    a, b, c = np.moveaxis(around.grown(0.05)[around.faces], 1, 0)
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
    assert volume == pytest.approx(ConvexHull(around.grown(0.05)).volume, rel=0.01), "its faces are outward"


def test_dynamic_obstacle_is_drawn_on_its_track(pendulum: Pendulum) -> None:
    scene = to.Scene(pendulum()).add("crate", to.Box(0.1, 0.1, 0.1), motion=PASSES)
    picture = posed(scene.add("cup", to.Sphere(0.03), to.placement((0.0, 0.0, 0.08)), frame="crate"))
    for time in (0.0, 0.17, 0.5):
        picture.pose(time)
        place = PASSES.at(time)
        crate, cup = (picture.data.geom(geom).xpos for geom in sorted(picture._coming))
        np.testing.assert_allclose(crate, place.translation, atol=1e-12)
        np.testing.assert_allclose(cup, place * np.array((0.0, 0.0, 0.08)), atol=1e-12)


def test_absent_object_is_not_drawn_and_hides_nothing(pendulum: Pendulum) -> None:
    scene = to.Scene(pendulum()).add(
        "post", to.Sphere(0.1), to.placement((0.3, 0.3, 1.0)), appears=0.2, expires=0.4
    )
    picture = posed(scene.add("part", to.Sphere(0.02), frame="tip", expires=0.3))
    assert [groups(picture, "post", time) for time in (0.1, 0.3, 0.5)] == [
        {UNSEEN_GROUP},
        {OBJECT_GROUP},
        {UNSEEN_GROUP},
    ]
    assert [groups(picture, "part", time) for time in (0.1, 0.5)] == [{ROBOT_GROUP}, {UNSEEN_GROUP}]


def test_halo_grows_with_time_and_appears_with_its_object(pendulum: Pendulum) -> None:
    known = to.Prediction(PASSES, (0.0, 0.1, 0.0))
    scene = to.Scene(pendulum()).add("crate", to.Box(0.1, 0.1, 0.1), motion=known, expires=0.4)
    picture = posed(scene.add("ball", to.Sphere(0.1), motion=PASSES))
    assert not any(name == "ball" for name, _ in picture._halos.values()), "its place is known exactly"
    assert [groups(picture, "crate", time) for time in (0.0, 0.3, 0.45)] == [
        {OBJECT_GROUP, UNSEEN_GROUP},
        {OBJECT_GROUP, HALO_GROUP},
        {UNSEEN_GROUP},
    ]
    for time in (0.2, 0.3):
        (mesh,) = picture.grow_halos(time)
        begin, count = picture.model.mesh_vertadr[mesh], picture.model.mesh_vertnum[mesh]
        points = picture.model.mesh_vert[begin : begin + count]
        reach = np.linalg.norm(points, axis=1).max()
        assert reach == pytest.approx(np.sqrt(3) * 0.05 + 0.1 * time, abs=1e-5)


def test_camera_has_passing_objects_in_view_but_not_far_ones(pendulum: Pendulum) -> None:
    scene, times = to.Scene(pendulum()), np.linspace(0.0, 0.4, 5)
    still, ball = np.zeros((5, 1)), to.Sphere(0.02)
    far = to.Track.through((0.0, 0.4), [to.placement((9.0, y, 1.2)) for y in (-5.0, 5.0)])
    near = to.Track.through((0.0, 0.4), [to.placement((0.5, y, 1.0)) for y in (0.0, 0.1)])
    bare, with_far, with_near, gone = (
        np.ptp(visible_points(reduced_all(each), still, times=times), axis=0)
        for each in (
            scene,
            scene.add("ball", ball, motion=far),
            scene.add("ball", ball, motion=near),
            scene.add("ball", ball, motion=near, appears=9.0),
        )
    )
    assert np.array_equal(with_far, bare) and np.array_equal(gone, bare)
    assert with_near[1] > bare[1] + 0.04


@pytest.mark.usefixtures("opengl")
def test_films_and_pictures_show_dynamic_obstacles(pendulum: Pendulum, tmp_path: Path) -> None:
    known = to.Prediction(PASSES, (0.02, 0.3, 0.0))
    scene = to.Scene(pendulum()).add("crate", to.Box(0.2, 0.2, 0.2), motion=known, appears=0.1)
    reduced, planned = held(scene)
    camera = CameraView(np.array((0.3, 0.0, 1.0)), 2.0, 2.5, -0.4)
    shown = [
        pixels(render(reduced, planned, tmp_path / f"{t}.png", **SIZE, moments=[t], camera=camera))
        for t in (0.0, 0.05, 0.15, 0.3)
    ]
    # The corner with the time in it is left out.
    changed = [(np.abs(a - b).max(axis=2)[:100] > 8.0).sum() for a, b in pairwise(shown)]
    assert changed[0] == 0 and min(changed[1:]) > 200
    both = render(
        reduced, planned, tmp_path / "both.png", **SIZE, layout=Layout.SUPERPOSED, moments=[0.1, 0.4]
    )
    assert np.ptp(pixels(both)) > 100
    film = render(simulate(reduced, planned), tmp_path / "film.gif", **SIZE, fps=10)
    assert film.stat().st_size > 1000


def test_links_of_one_robot_have_one_colour(pendulum: Pendulum) -> None:
    scene = to.Scene(pendulum())
    for name in ("post", "other/rod", "other/tip", "third/rod"):
        scene = scene.add(name, to.Sphere(0.1), to.placement((2.0, 0.0, 0.0)))
    colours = object_colours(reduced_all(scene))
    assert colours["other/rod"] == colours["other/tip"]
    assert len(set(colours.values())) == 3
