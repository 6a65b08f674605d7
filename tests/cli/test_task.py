"""`trajopt task`: a job in YAML is checked, planned and exported; mistakes are one line."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import trajopt as to
from trajopt.cli import app_for
from trajopt.files.bundle import read_result
from trajopt.tasks import AttachObject, OneOf, StageCost, StageLimits, Within, read_task
from trajopt.tasks.cartesian import Followed, follow, follows_curve, line
from trajopt.values.errors import FileFormatError, ProblemError

JOB = """
group: panda_arm
start: ready
stages:
  - move_to: {position: [0.5, 0.2, 0.3], rpy: [3.14159265, 0, 0]}
    name: above
  - dwell: 0.2
  - any_order:
      - [{move_to: {position: [0.5, 0.0, 0.3], rpy: [3.14159265, 0, 0]}, name: middle}, {dwell: 0.1}]
      - move_to: {position: [0.5, -0.2, 0.3], rpy: [3.14159265, 0, 0]}
        name: right
    then: ready
  - follow: panda_hand_tcp
    poses:
      - {position: [0.4, 0.1, 0.3], rpy: [3.14159265, 0, 0]}
      - {position: [0.5, 0.1, 0.3], rpy: [3.14159265, 0, 0]}
    speed: 0.1
    off: 0.05
  - move_to: {panda_joint1: 0.3}
    name: turn
"""
SHORT = JOB.partition("  - dwell")[0] + JOB[JOB.index("  - follow") :]
HANDLING = """
start: ready
group: panda_arm
blend: 0.03
stages:
  - pick: cup
  - place: cup
    at: {position: [0.5, 0.25, 0.06]}
  - move_object: door
    to: {position: [0.0, 0.9, 0.3]}
    seconds: 1
  - one_of: [[{move_to: ready}, {dwell: 1}], {move_to: extended}]
    cost: {duration: 1, clearance: 5}
    ways_each: 2
  - fallback: [{move_to: ready}]
  - within: [{move_to: ready}]
    limits: {duration: 5, clearance: 0.01, joints: {panda_joint1: [-1, 1]}}
  - gripper: 0.01
  - attach: door
    link: panda_hand_tcp
    touch_links: [panda_leftfinger, panda_rightfinger]
  - detach: door
"""


def run(*words: object) -> Result:
    return command("task", *words)


def command(*words: object) -> Result:
    return CliRunner().invoke(app_for([str(words[0])]), [*map(str, words)])


@pytest.fixture
def job(tmp_path: Path) -> Path:
    path = tmp_path / "job.yaml"
    path.write_text(JOB)
    return path


def test_a_job_is_planned_with_its_cycle_times(job: Path, tmp_path: Path) -> None:
    out = tmp_path / "result.json"
    done = run("plan", job, "--robot", "panda", "--out", out)
    assert done.exit_code == 0, done.output
    for stage in ("above", "dwell", "middle", "right", "  follow", "    retract", "turn"):
        assert stage in done.output
    assert json.loads(out.read_text())["verified"] is True


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A saved result, in a folder of its own."""
    path = tmp_path_factory.mktemp("saved")
    (path / "job.yaml").write_text(SHORT)
    done = run("plan", path / "job.yaml", "--robot", "panda", "--out", path / "job.trajopt")
    assert done.exit_code == 0, done.output
    return path / "job.trajopt"


def test_a_saved_result_is_checked(saved: Path) -> None:
    done = command("check", saved)
    assert done.exit_code == 0, done.output
    assert "follow: retract" in done.output and "velocity" in done.output
    assert json.loads(command("check", saved, "--json").output)["verified"] is True
    beside = command("check", saved, "--robot", "panda")
    assert isinstance(beside.exception, FileFormatError)
    assert "contains the whole problem" in str(beside.exception)


def test_a_saved_result_is_exported_reported_and_shown(saved: Path) -> None:
    done = command("export", saved, "--to", "csv", "--out", saved.with_suffix(".csv"))
    assert done.exit_code == 0, done.output
    done = command("report", saved, "--no-3d", "--out", saved.with_suffix(".html"))
    assert done.exit_code == 0, done.output
    assert "follow: retract" in saved.with_suffix(".html").read_text()
    done = command("view", saved, "--port", 0, "--seconds", 0)
    assert done.exit_code == 0, done.output
    done = command("simulate", saved, "--json")
    assert done.exit_code == 0, done.output
    assert json.loads(done.output)["succeeded"] is True


def test_commands_of_one_motion_refuse_the_result_of_several(saved: Path) -> None:
    for words in (("prove", saved, "--out", saved.with_suffix(".proof")), ("replay", saved)):
        done = command(*words)
        assert isinstance(done.exception, FileFormatError), done.output
        assert "is the result of " in str(done.exception)


def test_a_followed_curve_is_saved_and_read(tmp_path: Path) -> None:
    panda = to.load("panda")
    scene, path = to.Scene(panda), tmp_path / "line.trajopt"
    at = scene.placement_of("panda_hand_tcp", panda.positions("ready"))
    end = to.placement(at.translation + np.array((0.0, 0.1, 0.0)), rotation=at.rotation)
    curve = follows_curve("panda_hand_tcp", line(at, end))
    followed = follow(scene, curve, start="ready", group="panda_arm")
    followed.save(path)
    again = read_result(path)
    assert isinstance(again, Followed) and again.complete
    assert again.reason == followed.reason
    for words in (
        ("check", path),
        ("export", path, "--to", "csv", "--out", path.with_suffix(".csv")),
        ("report", path, "--no-3d", "--no-pictures", "--out", path.with_suffix(".html")),
    ):
        done = command(*words)
        assert done.exit_code == 0, done.output
    assert "followed, proven" in path.with_suffix(".html").read_text()


def test_a_job_is_checked_without_planning(job: Path) -> None:
    done = run("check", job, "--robot", "panda")
    assert done.output.split("\n")[:-1] == ["above", "dwell", "any order", "follow", "turn"]
    assert json.loads(run("check", job, "--robot", "panda", "--json").output)[0] == "above"


def test_a_job_is_exported_as_one_motion(job: Path, tmp_path: Path) -> None:
    out = tmp_path / "job.csv"
    done = run("export", job, "--robot", "panda", "--to", "csv", "--out", out)
    assert done.exit_code == 0, done.output
    assert len(out.read_text().splitlines()) > 100


def test_a_job_is_driven_recorded_and_shown(job: Path, tmp_path: Path) -> None:
    record, out = tmp_path / "run.json", tmp_path / "out.json"
    job.write_text(SHORT)
    done = run("run", job, "--robot", "panda", "--record", record, "--out", out)
    assert done.exit_code == 0, done.output
    assert "completed the task after" in done.output
    assert json.loads(out.read_text())["completed"] is True
    done = command("view", record, "--port", 0, "--seconds", 0)
    assert done.exit_code == 0, done.output


PICKING = """
group: panda_arm
start: ready
masses: {cup: 0.2}
stages:
  - pick: cup
  - place: cup
    at: {position: [0.5, 0.1, 0.06]}
"""
TABLE_AND_CUP = """
world:
  collision_objects:
    - id: table
      header: {frame_id: world}
      primitives: [{type: box, dimensions: [0.9, 1.4, 0.04]}]
      primitive_poses: [{position: [0.65, 0.0, -0.02], orientation: [0, 0, 0, 1]}]
    - id: cup
      header: {frame_id: world}
      primitives: [{type: cylinder, dimensions: [0.12, 0.03]}]
      primitive_poses: [{position: [0.5, -0.2, 0.06], orientation: [0, 0, 0, 1]}]
"""


def test_a_job_states_the_masses_that_moveits_scene_lacks(job: Path, tmp_path: Path) -> None:
    scene = tmp_path / "scene.yaml"
    scene.write_text(TABLE_AND_CUP)
    job.write_text(PICKING.replace("masses: {cup: 0.2}", ""))
    done = run("run", job, "--robot", "panda", "--scene", scene)
    assert "object 'cup' has no mass" in str(done.exception)
    job.write_text(PICKING)
    done = run("run", job, "--robot", "panda", "--scene", scene)
    assert done.exit_code == 0, done.output
    assert "completed the task after" in done.output


@pytest.mark.parametrize(
    ("masses", "words"),
    [("{cap: 0.2}", "no object named 'cap'; did you mean 'cup'"), ("{cup: -1}", "mass of cup: is negative")],
)
def test_a_mass_that_fits_nothing_is_refused(job: Path, tmp_path: Path, masses: str, words: str) -> None:
    scene = tmp_path / "scene.yaml"
    scene.write_text(TABLE_AND_CUP)
    job.write_text(PICKING.replace("{cup: 0.2}", masses))
    done = run("check", job, "--robot", "panda", "--scene", scene)
    assert isinstance(done.exception, FileFormatError)
    assert words in str(done.exception)


def test_a_job_without_a_plan_has_status_one(tmp_path: Path) -> None:
    path = tmp_path / "far.yaml"
    path.write_text("start: ready\ngroup: panda_arm\nstages: [{move_to: {position: [3, 0, 0]}, name: far}]")
    done = run("plan", path, "--robot", "panda")
    assert done.exit_code == 1
    assert "NO_INVERSE_KINEMATICS: far: " in done.output


def test_every_kind_of_stage_is_read(tmp_path: Path) -> None:
    scene = (
        to.Scene(to.load("panda"))
        .add("cup", to.Cylinder(radius=0.03, length=0.12), to.placement((0.5, -0.2, 0.06)), mass=0.2)
        .add("door", to.Box(0.1, 0.1, 0.1), to.placement((0.0, -0.9, 0.3)))
    )
    path = tmp_path / "job.yaml"
    path.write_text(HANDLING)
    task = read_task(path, scene)
    assert task.blend == 0.03
    assert task.name == "job"
    assert [type(stage).__name__ for stage in task.stages] == [
        *("PickObject", "PlaceObject", "MoveObject", "OneOf", "Fallback", "Within"),
        *("SetGripper", "AttachObject", "DetachObject"),
    ]
    chosen, limited = task.stages[3], task.stages[5]
    assert isinstance(chosen, OneOf) and isinstance(limited, Within)
    assert (chosen.cost, chosen.ways_each) == (StageCost(duration=1.0, clearance=5.0), 2)
    assert limited.limits == StageLimits(duration=5.0, clearance=0.01, joints={"panda_joint1": (-1.0, 1.0)})
    attached = task.stages[7]
    assert isinstance(attached, AttachObject)
    assert attached.touch_links == ("panda_leftfinger", "panda_rightfinger")


@pytest.mark.parametrize(
    ("stage", "words"),
    [
        ("{dwel: 1}", r"stages\[0\]: needs one of the keys move_to, dwell"),
        ("{dwell: 1, goal: ready}", "goal"),
        ("{within: [{dwell: 1}], limits: {durations: 1}}", "did you mean 'duration'"),
        ("{within: [{dwell: 1}], limits: {joints: {panda_joint1: [1]}}}", "the lowest and the highest"),
        ("{within: [{dwell: 1}], limits: {joints: {panda_joint: [0, 1]}}}", "no joint named 'panda_joint'"),
        ("{one_of: [{dwell: 1}], ways_each: 1.5}", "must be a whole number"),
        ("{one_of: [{dwell: 1}], cost: {duration: -1}}", "duration must be at least 0"),
        ("{move_to: ready, dwell: 1}", "needs one of the keys"),
        ("{dwell: -1}", r"stages\[0\]: seconds must be positive"),
        ("{move_to: redy}", "no state of group 'panda_arm' named 'redy'; did you mean 'ready'"),
        ("{pick: cup}", r"stages\[0\]: no object named 'cup'"),
        ("{follow: panda_hand_tcp, poses: [{position: [0, 0, 1]}]}", "at least two poses"),
        (
            "{follow: panda_hand_tcp, poses: [{position: [0, 0, 1]}, {position: [0, 1, 1]}], steady: 0.02}",
            r"stages\[0\].steady: needs a speed",
        ),
        ("{move_to: {position: [0.5, 0, 0.3], rpy: [0, 0, 0], quaternion: [0, 0, 0, 1]}}", "beside a quater"),
        ("{place: cup}", r"stages\[0\].at.position: is missing"),
    ],
)
def test_mistakes_name_the_stage(stage: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "job.yaml"
    path.write_text(f"start: ready\ngroup: panda_arm\nstages: [{stage}]")
    with pytest.raises((FileFormatError, ProblemError), match=words):
        read_task(path, to.Scene(to.load("panda")))


def test_a_missing_start_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "job.yaml"
    path.write_text("group: panda_arm\nstages: [{move_to: ready}]")
    with pytest.raises(FileFormatError, match="start: is missing"):
        read_task(path, to.Scene(to.load("panda")))
