"""`trajopt warehouse`: what goes in is listed, shown and comes out again."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

import trajopt as to
from trajopt.cli import app_for
from trajopt.files.bundle import save
from trajopt.planning.seeds import SeedKind
from trajopt.server.warehouse import Warehouse
from trajopt.values.errors import EntryNotFound, FileFormatError, ModelError, TrajoptError

SCENE = """
world:
  collision_objects:
    - id: ball
      primitives: [{type: sphere, dimensions: [0.1]}]
      primitive_poses: [{position: [0.65, 0.65, 0.1]}]
"""
REQUEST = """
group_name: arm
start_state: {joint_state: {name: [joint1, joint2], position: [0.0, 0.4]}}
goal_constraints:
  - joint_constraints: [{joint_name: joint1, position: 1.4}, {joint_name: joint2, position: 0.4}]
"""
STATE = "joint_state: {name: [joint1, joint2], position: [0.25, -0.5]}"
CONSTRAINTS = (
    "joint_constraints: [{joint_name: joint2, position: 0.4, tolerance_above: 0.2, tolerance_below: 0.1}]"
)


def ran(*words: str | Path) -> Result:
    return CliRunner().invoke(app_for(["warehouse"]), ["warehouse", *map(str, words)])


def said(*words: str | Path) -> str:
    done = ran(*words)
    assert done.exit_code == 0, (done.output, done.exception)
    return done.output


def refused(kind: type[TrajoptError], *words: str | Path) -> str:
    error = ran(*words).exception
    assert isinstance(error, kind), error
    return str(error)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    for name, text in (("s", SCENE), ("r", REQUEST), ("t", STATE), ("c", CONSTRAINTS)):
        (tmp_path / f"{name}.yaml").write_text(text)
    return tmp_path / "cell.warehouse"


@pytest.fixture
def filled(file: Path, tmp_path: Path) -> Path:
    arm = ("--robot", "planar2")
    said("add", file, "arm", *arm)
    said("add", file, "cell", *arm, "--scene", tmp_path / "s.yaml", "--tag", "fair", "--note", "by the door")
    said("add", file, "task", *arm, "--scene", tmp_path / "s.yaml", "--request", tmp_path / "r.yaml")
    said("add", file, "home", *arm, "--state", tmp_path / "t.yaml")
    said("add", file, "elbow", *arm, "--constraints", tmp_path / "c.yaml")
    return file


def test_each_kind_is_added_listed_and_shown(filled: Path) -> None:
    listed = json.loads(said("ls", filled, "--json"))
    assert {entry["name"]: entry["kind"] for entry in listed} == {
        "arm": "robot", "cell": "scene", "task": "problem", "home": "state", "elbow": "constraints",
    }  # fmt: skip
    table = said("ls", filled, "--robot", "planar2", "--scene", "cell")
    assert "task" in table and "cell" in table and "home" not in table
    assert "joint1" in said("show", filled, "home") and "0.25" in said("show", filled, "home")
    assert "by the door" in said("show", filled, "cell")
    assert "joint2" in said("show", filled, "elbow")
    assert json.loads(said("show", filled, "task", "--json"))["versions"] == [1]


def test_dates_tags_and_words_find(filled: Path) -> None:
    assert (
        said("ls", filled, "--since", "2020-01-01", "--until", "2999-01-01", "--tag", "fair").count("\n") == 2
    )
    assert said("ls", filled, "--until", "2020-01-01").strip() == "nothing"
    assert "cell" in said("ls", filled, "--text", "DOOR ball")
    assert "is not a date" in refused(ModelError, "ls", filled, "--since", "monday")
    assert "--kind must be one of" in refused(ModelError, "ls", filled, "--kind", "thing")


def test_bundles_and_warehouses_go_out_and_in(filled: Path, tmp_path: Path) -> None:
    bundle, other = tmp_path / "task.trajopt", tmp_path / "other.warehouse"
    said("export", filled, "task", "--out", bundle)
    assert "written to" in said("export", filled, "--out", other)
    assert "nothing new" in said("export", filled, "--out", other)
    assert len(json.loads(said("import", tmp_path / "third", other, bundle, "--json"))) == 6
    assert "name the entry" in refused(ModelError, "export", filled, "--out", bundle)


def test_an_import_takes_all_or_nothing(filled: Path, tmp_path: Path) -> None:
    target = tmp_path / "third"
    assert "no such file" in refused(FileFormatError, "import", target, filled, tmp_path / "none")
    assert said("ls", target).strip() == "nothing"


def test_a_plan_is_kept_from_its_bundle(filled: Path, tmp_path: Path) -> None:
    arm = to.load("planar2")
    problem = to.Problem(scene=to.Scene(arm), start=[0.0, 0.4], goal={"joint1": 0.4, "joint2": 0.4})
    to.plan(problem).save(tmp_path / "p.trajopt")
    entry = json.loads(said("add", filled, "task", "--bundle", tmp_path / "p.trajopt", "--json"))
    assert (entry["kind"], entry["status"]) == ("plan", "SOLVED")
    assert "SOLVED" in said("ls", filled, "--solved") and "SOLVED" not in said("ls", filled, "--failed")
    assert "give the kind" in refused(ModelError, "rm", filled, "task")
    assert "removed" in said("rm", filled, "task", "--kind", "plan")


def test_conflicting_arguments_are_refused(filled: Path, tmp_path: Path) -> None:
    save(
        to.Problem(scene=to.Scene(to.load("planar2")), start=[0.0, 0.4], goal={"joint1": 0.4}),
        tmp_path / "p.trajopt",
    )
    arm = ("--robot", "planar2")
    assert "--bundle or --robot" in refused(
        ModelError, "add", filled, "x", "--bundle", tmp_path / "p.trajopt", *arm
    )
    assert "give the entry" in refused(ModelError, "add", filled, "x")
    both = ("--state", tmp_path / "t.yaml", "--constraints", tmp_path / "c.yaml")
    assert "give one of" in refused(ModelError, "add", filled, "x", *arm, *both)
    assert "give one of" in refused(ModelError, "add", filled, "x", *arm, "--request", tmp_path / "r.yaml")
    assert "did you mean 'cell'" in refused(EntryNotFound, "show", filled, "sell")
    for day in ("--since", "0001-01-01T00:00+01:00"), ("--until", "9999-12-31"):
        assert "is not a date" in refused(ModelError, "ls", filled, *day)
    assert "no such file" in refused(FileFormatError, "ls", tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_plan_starts_from_the_memory_of_a_warehouse(file: Path, tmp_path: Path) -> None:
    words = ("--robot", "planar2", "--scene", tmp_path / "s.yaml", "--request", tmp_path / "r.yaml", "--json")
    for memories, remembered in (([], False), ([1], True)):
        done = CliRunner().invoke(app_for(["plan"]), ["plan", *map(str, words), "--experience", str(file)])
        assert done.exit_code == 0, (done.output, done.exception)
        told = json.loads(done.stdout)
        assert told["experience"]["memories"] == memories
        assert (told["won_by"] == SeedKind.GIVEN.name) is remembered
    assert len(Warehouse(file).experience()) == 1
