"""Plans and runs as logs for Rerun, read back by its own reader."""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trajopt as to
from tests.files.log.read_mcap import read as read_mcap
from trajopt.driving import IdealExecutor, Logbook, Supervisor, write_rerun
from trajopt.files.export import export
from trajopt.files.log.logs import FRAMES, JOINTS, PLAN, SCENE, RerunLog
from trajopt.values.errors import MissingExtra, ProblemError


def read(path: Path) -> dict[str, dict[str, list[Any]]]:
    """Return the columns of each entity by its path: "time" [s] and the components."""
    chunks = pytest.importorskip("rerun.chunk")
    found = dict[str, dict[str, list[Any]]]()
    for chunk in chunks.RrdReader(path).stream():
        columns = found.setdefault(chunk.entity_path, {})
        batch = chunk.to_record_batch()
        for name, column in zip(batch.schema.names, batch.columns, strict=True):
            values = [each.value / 1e9 for each in column] if name == "time" else column.to_pylist()
            columns.setdefault(name.rpartition(":")[2], []).extend(values)
    return found


def scene() -> to.Scene:
    things: list[tuple[str, Any]] = [
        ("a/box", to.Box(0.1, 0.2, 0.3)), ("ball", to.Sphere(0.05)), ("cone", to.Cone(0.1, 0.2)),
        ("post", to.Cylinder(0.05, 0.4)), ("pill", to.Capsule(0.05, 0.2)),
    ]  # fmt: skip
    found = to.Scene(to.load("panda"))
    for number, (name, shape) in enumerate(things):
        turned = to.placement((2.0 + number, 3.0, 0.5), rpy=(0.0, 0.5, 0.0))
        found = found.add(name, shape, turned)
    return found


@pytest.fixture(scope="module")
def plan() -> Any:
    goal = to.joint_positions({"panda_joint1": 0.3})
    return to.plan(to.Problem(scene=scene(), group="panda_arm", start="ready", goal=goal)).require()


def test_a_plan_has_joint_positions_frames_and_shapes(plan: Any, tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    export(plan, tmp_path / "plan.rrd", to="rerun")
    found = read(tmp_path / "plan.rrd")
    motion = plan.trajectory
    for order, name in enumerate(("position", "velocity", "acceleration")):
        for place, joint in enumerate(motion.joint_names):
            columns = found[f"/joint_states/{name}/{joint}"]
            expected = motion(np.array(columns["time"]), order)[:, place]
            np.testing.assert_allclose(np.ravel(columns["scalars"]), expected, atol=1e-5)
    frames = found["/world/ball"]
    np.testing.assert_allclose(frames["translation"][0], [(3.0, 3.0, 0.5)], atol=1e-6)
    assert len(frames["translation"]) == len(found["/joint_states/position/panda_joint1"]["time"])
    np.testing.assert_allclose(found[r"/world/a\/box/0"]["half_sizes"][0], [(0.05, 0.1, 0.15)], atol=1e-7)
    np.testing.assert_allclose(found["/world/ball/0"]["half_sizes"][0], [(0.05,) * 3], atol=1e-7)
    np.testing.assert_allclose(found["/world/post/0"]["lengths"][0], [0.4], atol=1e-7)
    assert {"/world/pill/0", "/world/pill/1", "/world/pill/2"} <= found.keys()
    corners = np.array(found["/world/cone/0"]["vertex_positions"][0])
    np.testing.assert_allclose(corners[24], (0.0, 0.0, 0.1), atol=1e-6)
    np.testing.assert_allclose(np.hypot(*corners[:24, :2].T), 0.1, atol=1e-6)


def test_a_run_has_events_and_objects_that_disappear(plan: Any, tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    problem = plan.problem
    arm = IdealExecutor(problem.reduced.joint_names, problem.reduced.start_positions)
    supervisor, logbook = Supervisor(arm, problem), Logbook()
    supervisor.go(problem)
    while supervisor.busy and arm.now() < 20.0:
        if supervisor.events and "ball" in supervisor.world.scene.objects and arm.now() > 0.2:
            supervisor.see(problem.scene.remove("ball"))
        supervisor.cycle()
        logbook.look(supervisor)
        arm.advance(0.02)
    write_rerun(tmp_path / "run.rrd", logbook.recording, origin=100.0)
    found = read(tmp_path / "run.rrd")
    texts = np.ravel(found["/events"]["text"]).tolist()
    assert "reached" in texts and set(np.ravel(found["/events"]["level"])) <= {"INFO", "WARN"}
    assert found["/events"]["time"] == pytest.approx([each.time + 100.0 for each in logbook.recording.events])
    cleared = found["/world/ball"]["is_recursive"]
    assert [each for each in cleared if each] == [[True]] and "is_recursive" not in found["/world/post"]
    assert any(path.startswith("/committed/") for path in found)


def test_the_messages_of_an_mcap_file_show_the_same(plan: Any, tmp_path: Path) -> None:
    """Robot, scene and motion, read by the official reader."""
    pytest.importorskip("rerun")
    export(plan, tmp_path / "plan.rrd", to="rerun")
    export(plan, tmp_path / "plan.mcap", to="mcap")
    topics = {each.name: each for each in (FRAMES, SCENE, JOINTS, PLAN)}
    log = RerunLog()
    for name, messages in read_mcap(tmp_path / "plan.mcap").items():
        for time, message in messages:
            log.add(topics[name], time, message)
    log.save(tmp_path / "again.rrd")
    shown, again = read(tmp_path / "plan.rrd"), read(tmp_path / "again.rrd")
    paths = {path for path in shown if path.startswith(("/world", "/joint_states", "/plan"))}
    assert len(paths) > 30 and paths <= again.keys()
    for path in paths:
        for drawn in (shown[path], again[path]):
            del drawn["rerun.controls.RowId"]
        assert again[path] == shown[path]


def test_negative_times_are_refused(plan: Any, tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    logbook = Logbook()
    arm = IdealExecutor(plan.problem.reduced.joint_names, plan.problem.reduced.start_positions)
    logbook.look(Supervisor(arm, plan.problem))
    with pytest.raises(ProblemError, match="must be finite and not negative"):
        write_rerun(tmp_path / "run.rrd", logbook.recording, origin=-1e6)
    assert list(tmp_path.iterdir()) == []


def test_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(MissingExtra, match=r"trajopt-planner\[rerun\]"):
        RerunLog()
