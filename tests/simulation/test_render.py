"""Pictures: they show the motion, the camera has everything in view, and errors name the remedy."""

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.simulation.conftest import panda, reduced_all, smooth
from trajopt.robot.robot import FrameAttachment, Robot
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model, tool_frame
from trajopt.scene.scene import Scene
from trajopt.simulation import (
    CameraView,
    Layout,
    RenderingUnavailable,
    picture_files,
    render,
    simulate,
    studio,
)
from trajopt.simulation.camera import FIELD_OF_VIEW, frame_points, visible_points
from trajopt.simulation.picture_model import ATTACHED, WOOD, object_colours
from trajopt.simulation.rendering import HEIGHT, WIDTH, thumbnail
from trajopt.simulation.sampled_motion import frame_times, motion_of
from trajopt.values.errors import FileFormatError, MissingExtra, ModelError, ShapeError
from trajopt.values.placement import placement
from trajopt.values.shapes.shapes import Box, Cone, Plane, Sphere
from trajopt.values.trajectory import Trajectory

SIZE = {"width": 160, "height": 120}


@pytest.fixture(scope="module")
def opengl() -> None:
    """Skip where nothing can be drawn."""
    try:
        studio.open_context(8, 8).free()
    except RenderingUnavailable as reason:
        pytest.skip(str(reason))


@pytest.fixture
def motion(odd: Robot) -> tuple[ReducedModel, Trajectory]:
    scene = Scene(odd).add("table", Box(0.4, 0.4, 0.02), placement((0.7, 0.0, 0.1)))
    scene = scene.add("hat", Cone(0.05, 0.1), placement((0.7, 0.1, 0.16))).add("ground", Plane())
    reduced = reduced_all(scene.add("part", Sphere(0.03), placement((0.1, 0, 0)), frame="tip"))
    planned = smooth(reduced, np.array((-0.5, 0.05, -0.5, 0.3)), np.array((0.7, 0.2, 0.2, -0.2)), 0.5)
    return reduced, planned


def pixels(path: Path) -> np.ndarray:
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB")).astype(float)


@pytest.mark.usefixtures("opengl")
def test_png_shows_robot_objects_and_path(motion: tuple[ReducedModel, Trajectory], tmp_path: Path) -> None:
    reduced, planned = motion
    done: list[float] = []
    path = render(reduced, planned, tmp_path / "a.png", **SIZE, moments=[0.2], progress=done.append)
    picture = pixels(path)
    assert picture.shape == (120, 160, 3)
    red, green, blue = np.moveaxis(picture, 2, 0)
    assert (blue - red > 60).sum() > 20, "the tool's path is blue"
    assert (red - blue > 80).sum() > 20, "the attached part is orange"
    assert np.ptp(green) > 80, "there is light and shadow"
    assert picture[:10].mean() > 200, "the sky is light"
    assert done == sorted(done) and done[-1] == 1.0


@pytest.mark.usefixtures("opengl")
def test_strip_superposed_and_film(motion: tuple[ReducedModel, Trajectory], tmp_path: Path) -> None:
    reduced, planned = motion
    rollout = simulate(reduced, planned)
    strip = pixels(render(reduced, rollout, str(tmp_path / "strip.png"), **SIZE))
    assert strip.shape == (2 * 120 + picture_files.GAP, 2 * 160 + picture_files.GAP, 3)
    first, last = strip[:120, :160], strip[-120:, -160:]
    assert np.abs(first - last).max() > 60, "the robot has moved"
    one = render(reduced, rollout, tmp_path / "one.png", **SIZE, layout=Layout.SUPERPOSED)
    assert pixels(one).shape == (120, 160, 3)
    with Image.open(render(reduced, rollout, tmp_path / "film.gif", **SIZE, fps=5.0)) as animation:
        assert animation.n_frames == 5
        assert animation.info["duration"] == 200


@pytest.mark.usefixtures("opengl")
def test_given_camera_is_used(motion: tuple[ReducedModel, Trajectory], tmp_path: Path) -> None:
    reduced, planned = motion
    away = CameraView(np.array((50.0, 0.0, 5.0)), 2.0, 0.0, 0.3)
    picture = pixels(render(reduced, planned, tmp_path / "a.png", **SIZE, moments=[0.0], camera=away))
    assert np.ptp(picture[:100].reshape(-1, 3), axis=0).max() < 60, "nothing but sky is there"


@pytest.mark.usefixtures("opengl")
def test_film_in_mp4(motion: tuple[ReducedModel, Trajectory], tmp_path: Path) -> None:
    av = pytest.importorskip("av", reason="films need the extra film")
    reduced, planned = motion
    path = render(reduced, planned, tmp_path / "a.mp4", **SIZE, fps=12.5)
    with av.open(str(path)) as written:
        stream = written.streams.video[0]
        assert (stream.codec_context.name, stream.average_rate) == ("h264", 12.5)
        pictures = [frame.to_ndarray(format="rgb24") for frame in written.decode(video=0)]
    assert len(pictures) == len(frame_times(motion_of(reduced, planned), 12.5))
    first = pixels(render(reduced, planned, tmp_path / "a.png", **SIZE, moments=[0.0]))
    assert pictures[0].shape == (120, 160, 3)
    assert np.abs(pictures[0] - first).mean() < 6.0 < np.abs(pictures[-1] - pictures[0].astype(float)).max()


def test_film_without_its_encoder_is_refused_before_drawing(
    motion: tuple[ReducedModel, Trajectory], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("trajopt.simulation.picture_files.find_spec", lambda _: None)
    with pytest.raises(MissingExtra, match=r"av is not installed.*\[film\]"):
        render(*motion, tmp_path / "a.mp4", **SIZE)


@pytest.mark.usefixtures("opengl")
def test_panda_is_drawn_from_its_visual_meshes(tmp_path: Path) -> None:
    robot = panda()
    reduced = reduce_model(Scene(robot), "panda_arm", robot.positions("ready"))
    start = reduced.start_positions
    planned = smooth(reduced, start, start + 0.3, 1.0)
    picture = pixels(render(reduced, planned, tmp_path / "panda.png", **SIZE, moments=[0.5]))
    assert np.ptp(picture, axis=(0, 1)).min() > 100


def test_missing_opengl_names_the_packages(
    motion: tuple[ReducedModel, Trajectory], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MUJOCO_GL", "disable")
    with pytest.raises(RenderingUnavailable, match="libegl1"):
        render(*motion, tmp_path / "a.png")
    assert not list(tmp_path.glob("*.png"))


def test_backends_without_a_display(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("MUJOCO_GL", "DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    here = {"EGL", "OSMesa"}
    monkeypatch.setattr(studio, "find_library", lambda name: name if name in here else None)
    assert studio.backends() == ("egl",)
    here.remove("EGL")
    assert studio.backends() == ("osmesa",)
    here.clear()
    assert studio.backends() == ()
    monkeypatch.setenv("DISPLAY", ":0")
    assert studio.backends() == ("glfw",)
    monkeypatch.setenv("MUJOCO_GL", "OSMesa ")
    assert studio.backends() == ("osmesa",)


@pytest.mark.parametrize("asked", ["osmesa", "nonsense"])
def test_physics_needs_no_opengl(asked: str) -> None:
    code = (
        "import os; from trajopt.robot.loading.mujoco_library import mujoco; print(os.environ['MUJOCO_GL'])"
    )
    environment = {**os.environ, "MUJOCO_GL": asked}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == asked


@pytest.mark.parametrize(
    ("name", "options", "error"),
    [
        ("a.jpg", {}, FileFormatError),
        ("nowhere/a.png", {}, FileFormatError),
        ("a.png", {"width": 0}, ShapeError),
        ("a.gif", {"fps": -1.0}, ShapeError),
        ("a.png", {"moments": [9.0]}, ShapeError),
        ("a.png", {"moments": []}, ShapeError),
    ],
)
def test_bad_requests(
    motion: tuple[ReducedModel, Trajectory],
    tmp_path: Path,
    name: str,
    options: dict[str, object],
    error: type[Exception],
) -> None:
    with pytest.raises(error):
        render(*motion, tmp_path / name, **options)  # type: ignore[arg-type]


def test_motion_of_another_group_is_refused(
    motion: tuple[ReducedModel, Trajectory], pendulum: Callable[..., Robot], tmp_path: Path
) -> None:
    other = reduced_all(Scene(pendulum()))
    rollout = simulate(other, smooth(other, np.zeros(1), np.zeros(1), 0.1))
    for wrong in (rollout, rollout.trajectory):
        with pytest.raises(ModelError, match="the trajectory moves swing"):
            render(motion[0], wrong, tmp_path / "a.png")


@pytest.mark.parametrize("azimuth", [0.3, 2.4, -2.0])
def test_camera_has_all_points_in_view(azimuth: float) -> None:
    points = np.random.default_rng(1).uniform((-0.5, -0.2, 0.0), (1.0, 0.4, 1.2), (40, 3))
    view = frame_points(points, azimuth, -0.4, 4 / 3)
    forward = (view.target - view.position) / view.distance
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    offset = points - view.position
    depth = offset @ forward
    half = np.tan(FIELD_OF_VIEW / 2)
    up = np.abs(offset @ np.cross(right, forward) / depth / half)
    across = np.abs(offset @ right / depth / half / (4 / 3))
    assert (depth > 0.0).all()
    assert 0.85 < max(up.max(), across.max()) <= 1.0


def test_view_is_clipped_around_large_and_far_objects(odd: Robot) -> None:
    bare = visible_points(reduced_all(Scene(odd)), np.zeros((1, 4)))
    scene = Scene(odd).add("floor", Plane()).add("slab", Box(20, 20, 0.1), placement((0, 0, -0.1)))
    scene = scene.add("moon", Sphere(1.0), placement((30.0, 0.0, 10.0)))
    points = visible_points(reduced_all(scene), np.zeros((1, 4)))
    assert np.linalg.norm(np.ptp(points, axis=0)) < 2.5 * np.linalg.norm(np.ptp(bare, axis=0))


def test_objects_have_different_colours(motion: tuple[ReducedModel, Trajectory]) -> None:
    colours = object_colours(motion[0])
    assert colours["part"] == ATTACHED
    assert colours["table"] == WOOD
    assert colours["hat"] not in (ATTACHED, WOOD)


def test_tool_is_a_named_frame_or_the_farthest_link(odd: Robot, planar_arm: Robot) -> None:
    assert tool_frame(reduced_all(Scene(odd))) == "finger"
    reduced = reduce_model(Scene(planar_arm), "arm", planar_arm.positions())
    assert tool_frame(reduced) == "left_finger"
    named = replace(planar_arm, frames={"grip": FrameAttachment("hand", placement((0.1, 0.0, 0.0)))})
    assert tool_frame(reduce_model(Scene(named), "arm", named.positions())) == "grip"


@pytest.mark.usefixtures("opengl")
def test_thumbnails_of_a_motion_and_of_its_start_alone(motion: tuple[ReducedModel, Trajectory]) -> None:
    reduced, planned = motion
    blue: list[int] = []
    for shown in (planned, None):
        with Image.open(BytesIO(thumbnail(reduced, shown))) as image:
            assert image.format == "JPEG" and image.size == (WIDTH, HEIGHT)
            colours = np.moveaxis(np.asarray(image).astype(float), 2, 0)
        blue.append(int((colours[2] - colours[0] > 90).sum()))
        assert (colours[0] - colours[2] > 80).sum() > 100, "the attached part is orange"
    assert blue[0] > blue[1] + 50, "the tool's path is blue"
