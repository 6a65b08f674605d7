import socket
import sys
import time
from collections.abc import Iterator
from urllib.parse import urlsplit

import numpy as np
import pytest

from trajopt.robot.loading.pinocchio_model import link_placement
from trajopt.scene.reducing import reduce_model
from trajopt.simulation.camera import FIELD_OF_VIEW
from trajopt.simulation.sampled_motion import motion_of
from trajopt.simulation.viewpoint import look_at
from trajopt.values.arrays import Floats
from trajopt.values.errors import MissingExtra, ShapeError
from trajopt.values.placement import placement
from trajopt.values.shapes.shapes import Box
from trajopt.values.trajectory import Trajectory
from trajopt.viewer import Viewer, view
from trajopt.viewer.readout import clearance_html, joints_html
from trajopt.viewer.scene_view import ASPECT

from .conftest import Motion


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


@pytest.fixture
def viewer(motion: Motion) -> Iterator[Viewer]:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    opened = view(motion.reduced, motion.trajectory, port=free_port())
    yield opened
    opened.close()


def expected_turn(motion: Motion, t: float) -> Floats:
    """Where the joint `turn` is: its link's frame is the joint's."""
    every = motion.reduced.all_positions(motion.trajectory(t))
    return link_placement(motion.reduced.scene.robot.model, "arm", every).homogeneous


@pytest.mark.parametrize("t", [0.0, 0.4, 1.5])
def test_show_moves_the_drawn_robot(motion: Motion, viewer: Viewer, t: float) -> None:
    viewer.show(t)
    assert viewer.time == t
    np.testing.assert_allclose(viewer.positions, motion.trajectory(t))
    np.testing.assert_allclose(
        viewer.joint_placement("turn").homogeneous, expected_turn(motion, t), atol=1e-6
    )


def test_time_is_clipped(viewer: Viewer) -> None:
    viewer.show(99.0)
    assert viewer.time == 1.5
    viewer.show(-1.0)
    assert viewer.time == 0.0


def test_playing_runs_to_the_end_and_starts_again(viewer: Viewer) -> None:
    viewer.show(1.3)
    viewer.play()
    deadline = time.monotonic() + 20.0
    while viewer.time < 1.5 and time.monotonic() < deadline:
        time.sleep(0.02)
    assert viewer.time == 1.5
    viewer.play()
    viewer.pause()
    paused = viewer.time
    assert paused < 1.5
    time.sleep(0.1)
    assert viewer.time == paused


def test_close_ends_waiting(viewer: Viewer) -> None:
    viewer.close()
    viewer.close()
    viewer.wait()


def test_two_viewers_get_two_ports(motion: Motion, viewer: Viewer) -> None:
    second = view(motion.reduced, motion.trajectory, port=urlsplit(viewer.url).port or 0)
    try:
        assert second.url != viewer.url
    finally:
        second.close()


def test_a_missing_extra_error_explains_how_to_install_it(
    motion: Motion, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(MissingExtra, match=r"trajopt-planner\[view\]"):
        view(motion.reduced, motion.trajectory)


def test_a_motion_of_other_joints_is_refused(motion: Motion) -> None:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    foreign = Trajectory(("elbow",), np.array([0.0, 1.0]), np.zeros((2, 1)))
    with pytest.raises(ShapeError, match="elbow"):
        view(motion.reduced, foreign)


def test_readout_in_words(motion: Motion, viewer: Viewer) -> None:
    viewer.show(1.5)
    nearest = viewer.nearest
    assert nearest is not None
    text = clearance_html(nearest)
    assert f"{nearest.distance * 1000:.1f} mm" in text
    assert "arm" in text
    assert "post" in text
    assert "nothing" in clearance_html(None)
    table = joints_html(motion.reduced.limits, viewer.positions, (False, True, True))
    assert "100.0 mm" in table
    assert "20.1&deg;" in table


def test_the_page_is_seen_from_where_pictures_are(motion: Motion, viewer: Viewer) -> None:
    chosen = look_at(motion.reduced, motion_of(motion.reduced, motion.trajectory), ASPECT).camera
    camera = viewer._server.initial_camera
    np.testing.assert_allclose(camera.position, chosen.position)
    np.testing.assert_allclose(camera.look_at, chosen.target)
    assert camera.fov == pytest.approx(FIELD_OF_VIEW)


def test_objects_that_hide_the_motion_are_translucent(motion: Motion) -> None:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    scene = motion.reduced.scene
    for name, x in (("front", 0.68), ("back", -0.3)):
        scene = scene.add(name, Box(0.02, 1.36, 4.0), placement((x, 0.0, 1.0)))
    for name, y in (("left", 0.68), ("right", -0.68)):
        scene = scene.add(name, Box(0.98, 0.02, 4.0), placement((0.19, y, 1.0)))
    walled = reduce_model(scene, motion.reduced.group, motion.reduced.start)
    opened = view(walled, motion.trajectory, port=free_port())
    try:
        seen_through = {name for name, handle in opened._scene.drawing._objects if handle.opacity is not None}
    finally:
        opened.close()
    expected = look_at(walled, motion_of(walled, motion.trajectory), ASPECT).hiding
    assert seen_through == expected and expected and expected <= {"front", "back", "left", "right"}


def test_viser_prints_nothing(motion: Motion, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    view(motion.reduced, motion.trajectory, port=free_port()).close()
    assert capsys.readouterr() == ("", "")
