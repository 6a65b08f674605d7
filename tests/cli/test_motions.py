"""`trajopt plan` and `trajopt check` among things that move."""

import json
from pathlib import Path

import pytest
from PIL import Image

import trajopt as to
from tests.cli.test_commands import common, folder, plan_file, trajopt
from trajopt.lab.suite.instance import find_instances

__all__ = ["folder", "plan_file"]
MOTIONS = """
- object: pillar
  times: [0.0, 0.6]
  positions: [[{x}, 0.0, 0.3], [{x}, 0.0, 2.3]]
"""


@pytest.mark.parametrize(("x", "status"), [(0.72, 0), (3.0, 0)])
def test_a_plan_among_things_that_move_is_checked_among_them(folder: Path, x: float, status: int) -> None:
    motions, plan = folder / f"motions{x}.yaml", folder / f"moving{x}.json"
    motions.write_text(MOTIONS.format(x=x))
    done = trajopt("plan", *common(folder), "--motions", motions, "--out", plan)
    assert done.returncode == status, done.stderr + done.stdout
    assert json.loads(plan.read_text())["source"]["motions"] == str(motions)
    checked = trajopt("check", *common(folder), "--motions", motions, plan)
    assert checked.returncode == 0 and "proven given that pillar is on its track" in checked.stdout


@pytest.fixture(scope="module")
def moving(folder: Path) -> tuple[Path, Path]:
    """Motions in which the pillar is lifted out of the way, and a plan among them."""
    motions, plan = folder / "lifted.yaml", folder / "lifted.json"
    motions.write_text(MOTIONS.format(x=0.72))
    assert trajopt("plan", *common(folder), "--motions", motions, "--out", plan).returncode == 0
    return motions, plan


@pytest.mark.parametrize("named", [False, True])
def test_a_plan_among_things_that_move_is_shown_among_them(
    folder: Path, moving: tuple[Path, Path], named: bool
) -> None:
    motions, plan = moving
    words = [*common(folder), "--motions", motions] if named else []
    done = trajopt("view", plan, *words, "--port", 0, "--seconds", 0.2)
    assert done.returncode == 0 and "open http" in done.stdout, done.stderr


def test_deadline_and_dwell_options_are_planned_and_judged(folder: Path, moving: tuple[Path, Path]) -> None:
    motions, plan = moving
    duration = json.loads(plan.read_text())["duration"]
    ends, written = ("--dwell", 0.5, "--finish-by", duration + 0.1), folder / "ends.json"
    done = trajopt("plan", *common(folder), "--motions", motions, *ends, "--out", written)
    assert done.returncode == 0, done.stderr + done.stdout
    assert "stays        0.5 s" in done.stdout and "finished by" in done.stdout
    source = json.loads(written.read_text())["source"]
    assert source["dwell"] == 0.5 and source["finish_by"] == pytest.approx(duration + 0.1)
    assert "dwell" not in json.loads(plan.read_text())["source"]
    least = ("--finish-by", duration / 2.0)
    late = trajopt("plan", *common(folder), "--motions", motions, *least)
    assert late.returncode == 1 and "TOO_LATE" in late.stdout
    judged = trajopt("check", *common(folder), "--motions", motions, *least, plan)
    assert judged.returncode == 1 and "finish" in judged.stdout
    assert trajopt("check", *common(folder), "--motions", motions, *ends, plan).returncode == 0
    for words, why in ((("--dwell", -1.0), "dwell"), (("--finish-by", 0.0), "finish_by must be after")):
        refused = trajopt("plan", *common(folder), *words)
        assert refused.returncode == 2 and why in refused.stderr and refused.stderr.count("\n") == 1


def test_an_obstacle_that_reaches_the_goal_later_is_met_during_the_dwell(
    folder: Path, moving: tuple[Path, Path]
) -> None:
    plan = moving[1]
    duration = json.loads(plan.read_text())["duration"]
    # It is back where it was when the arm has stayed for a while.
    back = folder / "back.yaml"
    back.write_text(
        f"- object: pillar\n  times: [0.0, 0.6, {duration + 1.0}, {duration + 2.0}]\n"
        "  positions: [[0.72, 0.0, 0.3], [0.72, 0.0, 2.3], [0.41, 0.63, 2.3], [0.41, 0.63, 0.3]]\n"
    )
    assert trajopt("check", *common(folder), "--motions", back, plan).returncode == 0
    stays = trajopt("check", *common(folder), "--motions", back, "--dwell", 3.0, plan)
    assert stays.returncode == 1 and "pillar" in stays.stdout


def test_bench_takes_the_motions_beside_a_scene(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "set").mkdir()
    for number in (1, 2):
        for kind in ("scene", "request"):
            copied = (folder / f"{kind}.yaml").read_text()
            (tmp_path / "set" / f"{kind}000{number}.yaml").write_text(copied)
    (tmp_path / "set" / "motions0002.yaml").write_text(MOTIONS.format(x=0.72).replace("0.6]", "6.0]"))
    written = tmp_path / "results.json"
    done = trajopt("bench", "--robot", folder / "odd.urdf", "--data", tmp_path, "--json", written)
    assert done.returncode == 0, done.stdout + done.stderr
    still, moving = json.loads(written.read_text())["problems"]
    assert still["verified"] and moving["verified"]
    late = trajopt("bench", "--robot", folder / "odd.urdf", "--data", tmp_path, "--finish-by", 0.1)
    assert '"TOO_LATE": 2' in late.stdout, late.stderr
    robot = to.Robot.from_urdf(folder / "odd.urdf")
    first, second = find_instances(tmp_path, robot)
    assert not first.make().scene.changing and second.make().scene.changing == ("pillar",)
    assert [path.name for path in second.files] == ["scene0002.yaml", "request0002.yaml", "motions0002.yaml"]
    (tmp_path / "set" / "motions0002.yaml").write_text("- object: ghost\n")
    refused = trajopt("bench", "--robot", folder / "odd.urdf", "--data", tmp_path)
    assert refused.returncode == 2 and "ghost" in refused.stderr


def test_simulation_prints_the_rollout(folder: Path, moving: tuple[Path, Path]) -> None:
    motions, plan = moving
    document = json.loads(trajopt("simulate", plan, "--json").stdout)
    assert document["contacts"] == [] and document["diverged"] is None
    assert document["tracking_error"]["maximum"][0] < 0.01
    stated = trajopt("simulate", plan, *common(folder), "--motions", motions, "--out", folder / "roll.json")
    assert stated.returncode == 0 and document["summary"] in stated.stdout, stated.stderr
    assert json.loads((folder / "roll.json").read_text())["positions"] == document["positions"]


def test_a_collision_in_simulation_is_an_exit_status(folder: Path, moving: tuple[Path, Path]) -> None:
    down = folder / "down again.yaml"
    down.write_text(MOTIONS.format(x=0.4).replace("2.3", "0.3"))
    done = trajopt("simulate", moving[1], "--motions", down)
    assert done.returncode == 1 and "pillar touches" in done.stdout, done.stderr + done.stdout


def test_simulation_refuses_invalid_options(folder: Path, moving: tuple[Path, Path]) -> None:
    for words, why in (
        (("--picture", folder / "a.bmp"), "use a suffix of .png, .gif, .mp4"),
        (("--moments", "0.1;0.2"), "--moments must be times with commas between, is '0.1;0.2'"),
        (("--robot", folder / "odd.urdf"), "with --robot give --scene and --request too"),
        (("--picture", folder / "a.png", "--highlight", "pilar"), "no link or object named 'pilar'"),
    ):
        done = trajopt("simulate", moving[1], *words)
        assert done.returncode == 2 and why in done.stderr and done.stderr.count("\n") == 1


def test_a_simulation_is_drawn(folder: Path, moving: tuple[Path, Path]) -> None:
    still, film, size = folder / "a.png", folder / "a.gif", ("--width", 160, "--height", 120)
    done = trajopt(
        "simulate", moving[1], "--picture", still, "--picture", film, *size, "--fps", 5, "--moments", "0,0.4"
    )
    if "RenderingUnavailable" in done.stderr or "OpenGL" in done.stderr:
        pytest.skip("no OpenGL here")
    assert done.returncode == 0, done.stderr
    with Image.open(still) as strip, Image.open(film) as frames:
        assert strip.size == (2 * 160 + 6, 120) and frames.n_frames > 4


def test_a_plan_that_stood_the_test_alone_may_fail_among_them(folder: Path, plan_file: Path) -> None:
    motions = folder / "down.yaml"
    motions.write_text(MOTIONS.format(x=0.4).replace("2.3", "0.3"))
    checked = trajopt("check", *common(folder), "--motions", motions, plan_file)
    assert checked.returncode == 1 and "pillar" in checked.stdout


@pytest.mark.parametrize("command", [("check",), ("simulate",), ("view",), ("prove", "--out", "x.proof")])
def test_a_motion_that_cannot_be_read_is_reported_as_such(
    command: tuple[str, ...], folder: Path, tmp_path: Path
) -> None:
    for name, why in ("none.csv", "No such file or directory"), ("folder.yaml", "Is a directory"):
        (tmp_path / "folder.yaml").mkdir(exist_ok=True)
        done = trajopt(*command, tmp_path / name, folder=tmp_path)
        assert done.returncode == 2 and f"{name}: cannot be read: {why}" in done.stderr
