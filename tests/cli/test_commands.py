"""The command line as a process: exit statuses, one-line errors, JSON."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.cli.process import trajopt
from tests.robots_for_tests import ODD_ARM
from trajopt.cli.suite import read_runs

SCENE = """
world:
  collision_objects:
    - id: pillar
      primitives: [{type: cylinder, dimensions: [1.0, 0.08]}]
      primitive_poses: [{position: [0.72, 0.0, 0.3], orientation: [0, 0, 0, 1]}]
"""
REQUEST = """
group_name: all
planner_id: SomebodyElses
max_velocity_scaling_factor: 0
start_state: {{joint_state: {{name: [pan, reach, elbow, wrist], position: [{start}, 0.1, 0.3, 0]}}}}
goal_constraints:
  - joint_constraints:
      - {{joint_name: pan, position: {goal}}}
      - {{joint_name: reach, position: 0.1}}
      - {{joint_name: elbow, position: 0.3}}
      - {{joint_name: wrist, position: 0.0}}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("cli")
    (path / "odd.urdf").write_text(ODD_ARM)
    (path / "scene.yaml").write_text(SCENE)
    (path / "request.yaml").write_text(REQUEST.format(start=-1.0, goal=1.0))
    (path / "blocked.yaml").write_text(REQUEST.format(start=-1.0, goal=0.0))
    (path / "set").mkdir()
    for number in (1, 2):
        (path / "set" / f"scene000{number}.yaml").write_text(SCENE)
        (path / "set" / f"request000{number}.yaml").write_text(REQUEST.format(start=-1.0, goal=2.0 - number))
    return path


def common(folder: Path, request: str = "request.yaml") -> list[object]:
    return ["--robot", folder / "odd.urdf", "--scene", folder / "scene.yaml", "--request", folder / request]


@pytest.fixture(scope="module")
def plan_file(folder: Path) -> Path:
    done = trajopt("plan", *common(folder), "--out", folder / "plan.json")
    assert done.returncode == 0, done.stderr + done.stdout
    assert "verified" in done.stdout and "clearance" in done.stdout
    return folder / "plan.json"


def test_plan_writes_the_promised_files(plan_file: Path) -> None:
    document = json.loads(plan_file.read_text())
    assert document["status"] == "SOLVED" and document["verified"] is True
    assert document["joint_names"] == ["pan", "reach", "elbow", "wrist"]
    assert set(document["points"][0]) == {"time_from_start", "positions", "velocities", "accelerations"}
    assert {"distance_calls", "forward_kinematics", "qp_solves", "qp_iterations"} <= set(document["counts"])
    assert {"optimise", "retime", "verify", "total"} <= set(document["cpu_seconds"])
    assert document["certificate"]["verified"] is True
    assert any("planner_id" in note for note in document["notes"])


def test_a_failure_is_explained_on_request(folder: Path) -> None:
    written = folder / "why.json"
    done = trajopt("plan", *common(folder, "blocked.yaml"), "--explain", "--out", written)
    assert done.returncode == 1
    assert "explanation\nGOAL_IN_COLLISION" in done.stdout and "makes it solvable" in done.stdout
    explanation = json.loads(written.read_text())["explanation"]
    assert explanation["certainty"] == "PROVEN" and explanation["remedies"]


def test_check_accepts_the_plan_and_refuses_it_changed(folder: Path, plan_file: Path) -> None:
    assert trajopt("check", *common(folder), plan_file).returncode == 0
    document = json.loads(plan_file.read_text())
    for point in document["points"]:
        point["time_from_start"] *= 0.5
        point["velocities"] = [2 * v for v in point["velocities"]]
        point["accelerations"] = [4 * a for a in point["accelerations"]]
    fast = folder / "fast.json"
    fast.write_text(json.dumps(document))
    refused = trajopt("check", *common(folder), fast, "--json")
    assert refused.returncode == 1
    failed = [c["name"] for c in json.loads(refused.stdout)["checks"] if c["required"] and not c["holds"]]
    assert "velocity" in failed


def test_prove_takes_the_points_of_any_planner(folder: Path, plan_file: Path) -> None:
    document = json.loads(plan_file.read_text())
    foreign = folder / "foreign.json"
    foreign.write_text(json.dumps({name: document[name] for name in ("joint_names", "points")}))
    proof = folder / "foreign.proof"
    proven = trajopt("prove", *common(folder), foreign, "--out", proof, "--json")
    assert proven.returncode == 0, proven.stderr
    assert json.loads(proven.stdout)["proven"] is True
    assert trajopt("check", proof).returncode == 0
    cut, none = folder / "cut.proof", folder / "no.proof"
    cut.write_bytes(proof.read_bytes()[:-1])
    for path, why in (cut, "the witness is shorter than "), (none, "cannot be read: "):
        for fast in (), ("--fast",):
            assert f"{path.name}: {why}" in trajopt("check", path, *fast).stderr
    unlike = trajopt("prove", *common(folder, "blocked.yaml"), foreign, "--out", folder / "none.proof")
    assert unlike.returncode == 2 and "judge refuses" in unlike.stderr
    assert not (folder / "none.proof").exists()


def test_export_writes_the_plan_for_a_controller(folder: Path, plan_file: Path) -> None:
    points = json.loads(plan_file.read_text())["points"]
    done = trajopt("export", plan_file, "--to", "ros2", "--out", folder / "goal.json")
    assert done.returncode == 0 and "the motion's own points" in done.stdout, done.stderr
    message = json.loads((folder / "goal.json").read_text())["trajectory"]
    assert message["joint_names"] == ["pan", "reach", "elbow", "wrist"]
    positions = [[point["positions"] for point in each] for each in (message["points"], points)]
    assert np.array(positions[0]) == pytest.approx(np.array(positions[1]), abs=1e-8)  # at whole nanoseconds
    table = folder / "plan.csv"
    said = json.loads(
        trajopt("export", plan_file, "--to", "csv", "--hz", 50, "--out", table, "--json").stdout
    )
    assert said["file"] == str(table) and said["points"] == len(table.read_text().splitlines()) - 1


@pytest.mark.parametrize(
    ("to", "says"),
    [("csw", "no format to export to named 'csw'; did you mean 'csv'"), ("csv", "no verified")],
)
def test_export_refuses_in_one_line(folder: Path, plan_file: Path, to: str, says: str) -> None:
    failed = {**json.loads(plan_file.read_text()), "verified": False, "message": "it collides"}
    (folder / "failed.json").write_text(json.dumps(failed))
    done = trajopt("export", folder / "failed.json", "--to", to, "--out", folder / "none.csv")
    assert done.returncode == 2 and says in done.stderr and len(done.stderr.splitlines()) == 1
    assert not (folder / "none.csv").exists()


def test_check_shows_the_required_clearance_as_the_bound(folder: Path, plan_file: Path) -> None:
    padded = folder / "padded.yaml"
    padded.write_text(
        (folder / "scene.yaml").read_text() + "link_padding: [{link_name: tip, padding: 0.9}]\n"
    )
    words = ["--robot", folder / "odd.urdf", "--scene", padded, "--request", folder / "request.yaml"]
    done = trajopt("check", *words, plan_file)
    assert done.returncode == 1
    (row,) = (line for line in done.stdout.splitlines() if line.split()[:2] == ["FAIL", "clearance"])
    assert row.split()[6] == "900" and "900 mm are required" in done.stdout


def test_check_judges_a_straight_line_through_the_pillar(folder: Path) -> None:
    line = {
        "joint_names": ["pan", "reach", "elbow", "wrist"],
        "points": [
            {"time_from_start": 0.0, "positions": [-1.0, 0.1, 0.3, 0.0]},
            {"time_from_start": 9.0, "positions": [1.0, 0.1, 0.3, 0.0]},
        ],
    }
    (folder / "line.json").write_text(json.dumps(line))
    done = trajopt("check", *common(folder), folder / "line.json")
    assert done.returncode == 1
    assert "pillar" in done.stdout


def test_continuous_joints_take_the_short_way(folder: Path) -> None:
    (folder / "turn.yaml").write_text(REQUEST.format(start=3.0, goal=-3.0))
    done = trajopt("plan", *common(folder, "turn.yaml"), "--json")
    assert done.returncode == 0, done.stderr
    pan = [point["positions"][0] for point in json.loads(done.stdout)["points"]]
    assert max(pan) - min(pan) < 0.5


def test_no_plan_is_exit_status_one(folder: Path) -> None:
    done = trajopt("plan", *common(folder, "blocked.yaml"), "--json")
    assert done.returncode == 1
    document = json.loads(done.stdout)
    assert document["status"] == "GOAL_IN_COLLISION" and "pillar" in document["message"]


def test_bench(folder: Path) -> None:
    out = folder / "bench.json"
    done = trajopt("bench", "--robot", folder / "odd.urdf", "--data", folder, "--sets", "set", "--json", out)
    assert done.returncode == 0, done.stdout + done.stderr
    document = json.loads(out.read_text())
    assert [p["status"] for p in document["problems"]] == ["SOLVED", "GOAL_IN_COLLISION"]
    assert document["summary"]["left_out"] == 1 and document["summary"]["success"] == 1.0
    for key in ("set", "index", "verified", "cpu_seconds", "counts", "path_length", "duration", "clearance"):
        assert key in document["problems"][0]
    assert [p["won_by"] for p in document["problems"]] == ["STRAIGHT", None]
    assert document["problems"][0]["tries"] == {"STRAIGHT": 1}
    assert document["summary"]["won_by"] == {"STRAIGHT": 1} and "won by 1 STRAIGHT" in done.stdout
    assert document["summary"]["stopped_by_clock"] == 0


def test_budget_options(folder: Path) -> None:
    """A budget too small for anything is told as such, in both commands; one to improve in is used up."""
    where = ("--robot", folder / "odd.urdf", "--data", folder, "--sets", "set")
    done = trajopt("bench", *where, "--time-budget", 1e-9, "--no-portfolio")
    assert done.returncode == 1 and "OUT_OF_TIME" in done.stdout
    done = trajopt("plan", *common(folder), "--json", "--time-budget", 1e-9)
    document = json.loads(done.stdout)
    assert done.returncode == 1 and document["status"] == "OUT_OF_TIME" and document["stopped_by_clock"]
    done = trajopt("plan", *common(folder), "--json", "--no-portfolio", "--improve")
    document = json.loads(done.stdout)
    assert done.returncode == 0 and document["won_by"] == "STRAIGHT" and len(document["tries"]) == 1
    done = trajopt("plan", *common(folder), "--improve")
    assert done.returncode == 2 and "give --time-budget, in seconds, too" in done.stderr


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"--robot": "pandaa"}, "pandaa"),
        ({"--scene": "nowhere.yaml"}, "nowhere.yaml"),
        ({"--request": "bad.yaml"}, "bad.yaml"),
        ({"--srdf": "nowhere.srdf"}, "nowhere.srdf"),
        ({"--limits": "scene.yaml"}, "joint_limits"),
    ],
    ids=str,
)
def test_bad_input_is_one_line_and_exit_status_two(folder: Path, change: dict[str, str], words: str) -> None:
    (folder / "bad.yaml").write_text("group_name: arms\n")
    words_given = common(folder)
    for option, text in change.items():
        value = text if option == "--robot" else folder / text
        if option in words_given:
            words_given[words_given.index(option) + 1] = value
        else:
            words_given += [option, value]
    done = trajopt("plan", *words_given)
    assert done.returncode == 2, done.stdout
    assert words in done.stderr
    assert "Traceback" not in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_unknown_set_names_near_ones(folder: Path) -> None:
    done = trajopt("bench", "--robot", folder / "odd.urdf", "--data", folder, "--sets", "sets")
    assert done.returncode == 2 and "'set'" in done.stderr


@pytest.mark.parametrize("command", ["demo", "plan", "check", "bench", "view"])
def test_help(command: str) -> None:
    done = trajopt(command, "--help")
    assert done.returncode == 0
    assert ("--json" in done.stdout and "exit status" in done.stdout.lower()) or command == "view"


def test_suite(folder: Path) -> None:
    out, page = folder / "suite.json", folder / "suite.html"
    wanted = "past_pillar_panda,start_in_collision"
    done = trajopt("suite", "--problems", wanted, "--random", 1, "--json", out, "--html", page)
    if "trajopt-planner[robots]" in done.stderr:
        pytest.skip(done.stderr)
    assert done.returncode == 0, done.stderr + done.stdout
    outcomes = read_runs(out)
    assert [(outcome.problem, outcome.instance, outcome.expected.name) for outcome in outcomes] == [
        ("past_pillar_panda", "fixed", "SOLVED"),
        ("past_pillar_panda", "random 1", "SOLVED"),
        ("start_in_collision", "fixed", "START_IN_COLLISION"),
    ]
    assert all(outcome.good and outcome.cpu_seconds > 0.0 for outcome in outcomes)
    assert all(outcome.constraints for outcome in outcomes[:2])
    assert "3 of 3 as expected" in done.stdout and "goal: axis" in done.stdout
    assert page.read_text().startswith("<!doctype html>") and "past_pillar_panda" in page.read_text()


def test_suite_knows_no_such_problem() -> None:
    done = trajopt("suite", "--problems", "past_pillow_panda")
    assert done.returncode == 2 and "past_pillar_panda" in done.stderr


def test_compare(folder: Path) -> None:
    (folder / "sets").mkdir()
    (folder / "set").rename(folder / "sets" / "set")
    first, page, told = folder / "compare.json", folder / "compare.html", folder / "compare.md"
    asked = ["--data", folder / "sets", "--robot", folder / "odd.urdf", "--limit", 1, "--attempts", 1]
    done = trajopt("compare", *asked, "--solver", "sqp", "--solver", "chomp", "--json", first)
    (folder / "sets" / "set").rename(folder / "set")
    assert done.returncode == 0, done.stderr
    results = json.loads(first.read_text())["results"]
    assert [(run["problem"], run["solver"]) for run in results] == [("set/1", "sqp"), ("set/1", "chomp")]
    assert results[0]["verified"] and results[0]["clearance"] > 0.0 and results[0]["history"]
    again = trajopt("compare", "--results", first, "--html", page, "--markdown", told)
    assert again.returncode == 0, again.stderr
    assert "chomp" in again.stdout and "data:image/png" in page.read_text()
    assert told.read_text().startswith("| solver |")


def test_compare_refuses_other_files(folder: Path) -> None:
    for text, why in ("[]", "holds no runs that compare or suite wrote\n"), ("[", "cannot be parsed: "):
        (folder / "runs.json").write_text(text)
        done = trajopt("compare", "--results", folder / "runs.json")
        assert done.returncode == 2 and f"runs.json: {why}" in done.stderr
    assert trajopt("compare", "--solver", "chump").returncode == 2


def test_notes_on_the_robot_are_printed_and_torque_limits_turned_off(folder: Path, plan_file: Path) -> None:
    (folder / "noted.srdf").write_text(
        '<robot name="odd"><group name="all"><joint name="pan"/><joint name="reach"/><joint name="elbow"/>'
        '<joint name="wrist"/></group><group name="legs"><joint name="knee"/></group></robot>'
    )
    words = [
        "--robot",
        folder / "odd.urdf",
        "--srdf",
        folder / "noted.srdf",
        "--scene",
        folder / "scene.yaml",
    ]
    words += ["--request", folder / "request.yaml", "--torque-scaling", "inf"]
    for done in (trajopt("check", *words, plan_file), trajopt("plan", *words)):
        assert done.returncode == 0, done.stderr
        assert "group 'legs' is left out: no joint" in done.stdout
        assert "torque limits of all joints are turned off" in done.stdout


def test_a_shorter_motion_and_chosen_jerk_limits_on_request(folder: Path, plan_file: Path) -> None:
    done = trajopt("plan", *common(folder), "--free-duration", "--limit-jerk", "--json")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert document["method"]["name"] == "free-duration"
    assert document["duration"] <= document["along_path"]
    assert any("jerk limits of pan" in note for note in document["notes"])
    assert any(check["name"] == "jerk" for check in document["certificate"]["checks"])
    assert document["source"]["limit_jerk"] is True
    plain = json.loads(plan_file.read_text())
    assert plain["along_path"] is None and plain["source"]["limit_jerk"] is False
    shown = trajopt("plan", *common(folder), "--free-duration").stdout
    assert "motion of" in shown and "along the path" in shown and "method free-duration" in shown


def test_every_goal_of_a_request_is_compared(folder: Path) -> None:
    single = REQUEST.format(start=-1.0, goal=1.0)
    begin = single.index("  - joint_constraints:")
    (folder / "several.yaml").write_text(single + single[begin:].replace("position: 1.0", "position: -0.5"))
    done = trajopt("plan", *common(folder, "several.yaml"), "--every-goal")
    assert done.returncode == 0, done.stderr
    table = done.stdout.split("every goal\n")[1].splitlines()
    assert table[0].split()[0] == "goal" and "goal 2" in table[1] and "goal 1" in table[2]
    refused = trajopt("plan", *common(folder), "--every-goal")
    assert refused.returncode == 2 and "any_of" in refused.stderr


def test_view_with_json_prints_only_its_address(plan_file: Path) -> None:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    done = trajopt("view", plan_file, "--seconds", 0.1, "--port", 0, "--json")
    assert done.returncode == 0 and json.loads(done.stdout)["url"].startswith("http://127.0.0.1:")


def test_demo_refuses_a_file_as_folder(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert trajopt("demo", "--no-picture", "--out", tmp_path / "file").returncode == 2


def test_demo_without_pictures(tmp_path: Path) -> None:
    done = trajopt("demo", "--problem", "planar_fold", "--no-picture", "--out", tmp_path / "demo")
    assert done.returncode == 0 and "simulated in MuJoCo" in done.stdout
    assert (tmp_path / "demo" / "plan.json").is_file()


def test_srdf(folder: Path) -> None:
    done = trajopt("srdf", folder / "odd.urdf", "--out", folder / "odd.srdf")
    assert done.returncode == 0 and (folder / "odd.srdf").read_text().startswith("<")
