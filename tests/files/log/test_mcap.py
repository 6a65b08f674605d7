"""Plans as MCAP logs, read back by the official reader."""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from typer.testing import CliRunner

import trajopt as to
from tests.files.log.read_mcap import read, seconds
from trajopt.cli import app_for
from trajopt.files.export import Mcap, export
from trajopt.files.log.logs import EVENTS, McapLog, stamp
from trajopt.files.log.robot_messages import RobotMessages
from trajopt.scene.reducing import reduce_model
from trajopt.values.arrays import Floats
from trajopt.values.errors import MissingExtra, ProblemError

pytest.importorskip("mcap")
GROUP = "panda_arm"
TIMES = np.array((0.0, 1.0))


@pytest.fixture(scope="module")
def panda() -> to.Robot:
    return to.load("panda")


def swing(panda: to.Robot) -> to.Trajectory:
    joints = panda.group(GROUP).joints
    begin = panda.positions("ready")[panda.index(joints)]
    still = np.zeros((2, 7))
    return to.Trajectory(joints, TIMES, np.stack((begin, begin + 0.1)), still, still)


def placement_of(transform: Mapping[str, Any]) -> Floats:
    """Return a transform as a matrix, shape (4, 4)."""
    at, turn = transform["translation"], transform["rotation"]
    quaternion = pin.Quaternion(np.array([turn[axis] for axis in "xyzw"]))
    return pin.SE3(quaternion, np.array([at[axis] for axis in "xyz"])).homogeneous


def test_a_plan_has_joint_states_frames_and_scene(panda: to.Robot, tmp_path: Path) -> None:
    scene = to.Scene(panda).add("post", to.Box(0.1, 0.2, 1.0), to.placement((0.8, 0.5, 0.5)))
    motion, reduced = swing(panda), reduce_model(scene, GROUP, panda.positions("ready"))
    written = export(motion, tmp_path / "plan.mcap", to=Mcap(reduced))
    topics = read(tmp_path / "plan.mcap")
    assert set(topics) == {"/joint_states", "/tf", "/scene", "/plan"}
    assert written.points == len(topics["/joint_states"]) == len(topics["/tf"]) == 51
    for time, message in topics["/joint_states"]:
        assert seconds(message["timestamp"]) == pytest.approx(time, abs=1e-9)
        rows = [
            [joint[key] for joint in message["joints"]] for key in ("position", "velocity", "acceleration")
        ]
        for order, row in enumerate(rows):
            np.testing.assert_allclose(row, motion(time, order), atol=1e-7)
    for time, message in topics["/tf"][::10]:
        model = panda.model
        data, full = model.createData(), np.array(panda.positions("ready"))
        full[panda.index(motion.joint_names)] = motion(time)
        pin.framesForwardKinematics(model, data, panda.configuration(full))
        for transform in message["transforms"]:
            assert transform["parent_frame_id"] == "world"
            if model.existFrame(name := transform["child_frame_id"]):
                expected = data.oMf[model.getFrameId(name)].homogeneous
                np.testing.assert_allclose(placement_of(transform), expected, atol=1e-7)
    ((time, drawn),) = topics["/scene"]
    post = next(each for each in drawn["entities"] if each["id"] == "post")
    assert time == 0.0 and post["frame_id"] == "post" and post["frame_locked"]
    assert post["cubes"][0]["size"] == {"x": 0.1, "y": 0.2, "z": 1.0}
    assert post["cubes"][0]["pose"]["position"] == {"x": 0.0, "y": 0.0, "z": 0.0}
    assert {"panda_link5", "panda_hand"} <= {each["id"] for each in drawn["entities"]}
    ((_, whole),) = topics["/plan"]
    np.testing.assert_array_equal(whole["positions"], motion.positions)


def test_every_shape_is_drawn(panda: to.Robot, tmp_path: Path) -> None:
    corners = np.array([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)], dtype=np.float64)
    shapes = {
        "box": to.Box(0.1, 0.1, 0.1),
        "ball": to.Sphere(0.1),
        "tube": to.Cylinder(0.1, 0.3),
        "pill": to.Capsule(0.1, 0.3),
        "tip": to.Cone(0.1, 0.3),
        "wedge": to.convex(corners),
        "cloud": to.Points(corners, radius=0.01),
    }
    scene = to.Scene(panda)
    for count, (name, shape) in enumerate(shapes.items()):
        scene = scene.add(name, shape, to.placement((1.0, 0.5 * count, 0.0)))
    scene = scene.add("floor", to.Plane(), to.placement((0.0, 0.0, -0.5)))
    reduced = reduce_model(scene, GROUP, panda.positions("ready"))
    export(swing(panda), tmp_path / "shapes.mcap", to=Mcap(reduced), hz=1.0)
    ((_, drawn),) = read(tmp_path / "shapes.mcap")["/scene"]
    kinds = ("cubes", "spheres", "cylinders", "triangles")
    counts = {each["id"]: tuple(len(each[kind]) for kind in kinds) for each in drawn["entities"]}
    assert {name: counts[name] for name in (*shapes, "floor")} == {
        "box": (1, 0, 0, 0),
        "ball": (0, 1, 0, 0),
        "tube": (0, 0, 1, 0),
        "pill": (0, 2, 1, 0),
        "tip": (0, 0, 1, 0),
        "wedge": (0, 0, 0, 1),
        "cloud": (0, 0, 0, 1),
        "floor": (1, 0, 0, 0),
    }
    entities = {each["id"]: each for each in drawn["entities"]}
    assert entities["tip"]["cylinders"][0]["top_scale"] == 0.0
    assert entities["tube"]["cylinders"][0]["size"] == {"x": 0.2, "y": 0.2, "z": 0.3}
    heights = sorted(each["pose"]["position"]["z"] for each in entities["pill"]["spheres"])
    np.testing.assert_allclose(heights, (-0.15, 0.15))
    for name in ("wedge", "cloud"):
        (triangles,) = entities[name]["triangles"]
        assert len(triangles["indices"]) % 3 == 0
        assert max(triangles["indices"]) < len(triangles["points"])


def test_objects_move_appear_and_disappear(panda: to.Robot, tmp_path: Path) -> None:
    scene = to.Scene(panda).add("cart", to.Box(0.1, 0.1, 0.1), to.placement((1.0, 0.0, 0.2)))
    ends = [to.placement((1.0, y, 0.2)) for y in (0.0, 1.0)]
    track = to.Track.through([0.0, 2.0], ends)
    scene = scene.with_motion("cart", track, appears=0.2, expires=0.65)
    reduced = reduce_model(scene, GROUP, panda.positions("ready"))
    log, times = McapLog(), np.linspace(0.0, 1.0, 11)
    RobotMessages(reduced).write(log, times + 5.0, np.tile(reduced.start_positions, (11, 1)), times)
    log.save(tmp_path / "cart.mcap")
    topics = read(tmp_path / "cart.mcap")
    present = {round(time, 1): "cart" in str(drawn["entities"]) for time, drawn in topics["/scene"]}
    assert present == {5.0: False, 5.2: True, 5.7: False}
    for time, message in topics["/tf"]:
        (cart,) = (each for each in message["transforms"] if each["child_frame_id"] == "cart")
        np.testing.assert_allclose(cart["translation"]["y"], 0.5 * (time - 5.0), atol=1e-7)


def test_a_trajectory_alone_has_joint_states_only(panda: to.Robot, tmp_path: Path) -> None:
    written = export(swing(panda), tmp_path / "alone.mcap", to="mcap", hz=10.0)
    topics = read(tmp_path / "alone.mcap")
    assert set(topics) == {"/joint_states", "/plan"} and len(topics["/joint_states"]) == 11
    assert "without frames and scene" in str(written)


def test_the_command_writes_a_bundle_with_its_scene(tmp_path: Path) -> None:
    result = to.plan(to.named_problem("planar_fold"))
    result.save(tmp_path / "plan.trajopt")
    words = ["export", str(tmp_path / "plan.trajopt"), "--to", "mcap", "--out", str(tmp_path / "a.mcap")]
    assert CliRunner().invoke(app_for(["export"]), words).exit_code == 0
    export(result, tmp_path / "b.mcap", to="mcap")
    one, other = read(tmp_path / "a.mcap"), read(tmp_path / "b.mcap")
    assert one["/tf"] and one["/scene"] and one == other


def test_a_log_refuses_times_that_the_format_lacks() -> None:
    log = McapLog()
    for time in (-1e-3, np.nan, np.inf):
        with pytest.raises(ProblemError, match="not negative"):
            log.add(EVENTS, time, {})
    assert stamp(2.5) == {"sec": 2, "nsec": 500_000_000}


def test_without_the_package_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mcap.writer", None)
    with pytest.raises(MissingExtra, match=r"trajopt-planner\[mcap\]"):
        McapLog()
