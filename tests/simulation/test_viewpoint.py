"""Viewpoints: the whole motion is in view, hardly hidden, and hiding objects are translucent."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.robots_for_tests import odd_arm
from tests.simulation.conftest import panda, reduced_all, smooth
from trajopt.robot.load import load
from trajopt.robot.robot import Robot
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model, tool_frames
from trajopt.scene.scene import Scene
from trajopt.simulation import CameraView, RenderingUnavailable, render, studio, viewpoint
from trajopt.simulation.camera import FIELD_OF_VIEW, picture_coordinates
from trajopt.simulation.picture_model import tool_paths
from trajopt.simulation.sampled_motion import SampledMotion, motion_of
from trajopt.simulation.viewpoint import look_at
from trajopt.values.arrays import Floats
from trajopt.values.placement import placement
from trajopt.values.shapes.shapes import Box

ASPECT = 4 / 3
HALF = np.tan(FIELD_OF_VIEW / 2)
"""Half the height of a picture, in its coordinates."""


@pytest.fixture
def arm(tmp_path: Path) -> Robot:
    return odd_arm(tmp_path)


def swing(scene: Scene) -> tuple[ReducedModel, SampledMotion]:
    """The arm turns by a radian about the vertical, far out on the side of +x."""
    reduced = reduced_all(scene)
    start, end = np.array((-0.5, 0.1, -0.2, 0.0)), np.array((0.5, 0.1, 0.2, 0.0))
    return reduced, motion_of(reduced, smooth(reduced, start, end, 1.0))


def wall(side: float, *, height: float = 1.2) -> tuple[Box, Floats]:
    """A wall along y, before the arm (side 1) or behind it (side -1)."""
    return Box(0.02, 3.0, height), np.array((0.4 + 0.5 * side, 0.0, height / 2))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_camera_is_not_behind_a_wall(arm: Robot, side: float) -> None:
    shape, at = wall(side)
    reduced, motion = swing(Scene(arm).add("wall", shape, placement(at)))
    found = look_at(reduced, motion, ASPECT)
    assert not found.hiding
    assert np.sign(found.camera.position[0] - at[0]) == -side
    behind = replace(found.camera, azimuth=0.0 if side < 0.0 else np.pi, elevation=-0.1, distance=2.0)
    assert viewpoint.seen_from(posed(reduced, motion), behind).hiding == {"wall"}


def posed(reduced: ReducedModel, motion: SampledMotion) -> viewpoint.PosedModel:
    return viewpoint.PosedModel(reduced, motion, viewpoint.in_view(reduced, motion))


def test_viewpoint_is_deterministic(arm: Robot) -> None:
    views = [look_at(*swing(Scene(arm)), ASPECT).camera for _ in range(2)]
    np.testing.assert_array_equal(views[0].position, views[1].position)
    np.testing.assert_array_equal(views[0].target, views[1].target)


def test_robot_and_tool_path_fill_the_picture_and_a_large_table_does_not(arm: Robot) -> None:
    table = Scene(arm).add("table", Box(6.0, 6.0, 0.04), placement((0.0, 0.0, -0.05)))
    reduced, motion = swing(table)
    camera = look_at(reduced, motion, ASPECT).camera
    links = [
        reduced.scene.placement_of(link, reduced.all_positions(motion(t))).translation
        for t in np.linspace(0.0, motion.duration, 40)
        for link in arm.links
    ]
    points = np.concatenate((tool_paths(reduced, motion).reshape(-1, 3), np.array(links)))
    drawn = np.abs(picture_coordinates(camera, points)) / (HALF * np.array((ASPECT, 1.0)))
    assert drawn.max() <= 1.0, "all of it is in the picture"
    assert drawn.max() > 0.7, "which it fills"


def test_no_other_direction_shows_more(arm: Robot) -> None:
    """What is chosen shows as much of the tool's path as any, but for what it shows more of the robot."""
    shape, at = wall(1.0, height=0.6)
    reduced, motion = swing(Scene(arm).add("wall", shape, placement(at)))
    model, shown = posed(reduced, motion), viewpoint.in_view(reduced, motion)
    chosen = look_at(reduced, motion, ASPECT).camera
    scores = {}
    for elevation in viewpoint.ELEVATIONS:
        for azimuth in viewpoint.AZIMUTHS:
            camera = viewpoint.frame_points(shown, float(azimuth), float(elevation), ASPECT)
            scores[round(float(azimuth), 9), round(float(elevation), 9)] = plain_score(model, camera)
    best = max(scores.values())
    mine = scores[round(chosen.azimuth, 9), round(chosen.elevation, 9)]
    assert best > 0.0
    assert mine >= best * (1.0 - viewpoint.STEEPER * (len(viewpoint.ELEVATIONS) - 1))


def plain_score(model: viewpoint.PosedModel, camera: CameraView) -> float:
    """Seen lengths of tools' paths and robot in a picture, multiplied; each piece looked at by itself."""
    seen = np.zeros(2)
    for curves in viewpoint._moments(model):  # pyright: ignore[reportPrivateUsage]
        near = viewpoint.THICKNESS * curves.lengths[curves.tools :].sum()
        for count, piece in enumerate(curves.pieces):
            ray = piece.mean(axis=0) - camera.position
            reach = float(np.linalg.norm(ray))
            hits = [viewpoint._first_hits(model, camera.position, ray[None], group)[0] for group in (1, 2)]  # pyright: ignore
            if hits[0] >= 1.0 - near / reach and hits[1] >= 1.0:
                a, b = picture_coordinates(camera, piece)
                seen[int(count >= curves.tools)] += float(np.linalg.norm(b - a))
    return float(seen.prod())


def test_object_that_hides_the_motion_is_translucent(arm: Robot) -> None:
    scene = Scene(arm).add("table", Box(3.0, 3.0, 0.02), placement((0.0, 0.0, -0.3)))
    for name, x, y in (("front", 0.9, 0.0), ("back", -0.2, 0.0)):
        scene = scene.add(name, Box(0.02, 1.4, 3.0), placement((x, y, 0.7)))
    for name, x, y in (("left", 0.35, 0.6), ("right", 0.35, -0.6)):
        scene = scene.add(name, Box(1.1, 0.02, 3.0), placement((x, y, 0.7)))
    scene = scene.add("cup", Box(0.3, 0.3, 0.3), placement((0.1, 0.0, 0.0)), frame="tip")
    hiding = look_at(*swing(scene), ASPECT).hiding
    assert hiding and hiding <= {"front", "back", "left", "right"}


def test_the_tool_is_seen_through_a_wall(arm: Robot, tmp_path: Path) -> None:
    try:
        studio.open_context(8, 8).free()
    except RenderingUnavailable as reason:
        pytest.skip(str(reason))
    shape, at = wall(1.0, height=3.0)
    reduced, motion = swing(Scene(arm).add("wall", shape, placement(at)))
    planned = smooth(reduced, motion.positions[0], motion.positions[-1], 1.0)
    outside = CameraView(np.array((0.5, 0.0, 0.3)), 3.5, np.pi, -0.2)
    path = render(reduced, planned, tmp_path / "a.png", width=160, height=120, moments=[0.5], camera=outside)
    with Image.open(path) as image:
        picture = np.asarray(image.convert("L")).astype(float)
    across = slice(40, 110), slice(40, 120)
    assert np.ptp(picture[across]) > 25.0, "the arm shows through"


def test_each_arm_draws_its_own_path() -> None:
    panda()  # skips where the models are not installed
    robot = load("two_pandas")
    both = max(robot.groups, key=lambda name: len(robot.groups[name].joints))
    reduced = reduce_model(Scene(robot), both, robot.positions())
    frames = tool_frames(reduced)
    assert len(frames) == 2 and len({reduced.attachment(name)[0] for name in frames}) == 2
    motion = SampledMotion(
        np.array((0.0, 1.0)), np.stack((reduced.start_positions, reduced.start_positions + 0.2))
    )
    paths = tool_paths(reduced, motion)
    assert len(paths) == 2 and np.linalg.norm(paths[0] - paths[1], axis=1).min() > 0.1


def test_robot_at_rest_has_a_viewpoint(arm: Robot) -> None:
    reduced = reduced_all(Scene(arm))
    still = SampledMotion(np.array((0.0, 1e-3)), np.repeat(reduced.start_positions[None], 2, axis=0))
    assert look_at(reduced, still, ASPECT).camera.distance > 0.1
