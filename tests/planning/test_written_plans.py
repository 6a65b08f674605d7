"""Plans written from Python are what the commands read."""

import json
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.cli.process import trajopt
from tests.cli.test_commands import REQUEST, SCENE, common
from tests.robots_for_tests import ODD_ARM
from trajopt.files.moveit import read_request, read_scene, read_trajectory
from trajopt.values.errors import FileFormatError, ProblemError


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "odd.urdf").write_text(ODD_ARM)
    (tmp_path / "scene.yaml").write_text(SCENE)
    (tmp_path / "request.yaml").write_text(REQUEST.format(start=-1.0, goal=1.0))
    (tmp_path / "blocked.yaml").write_text(REQUEST.format(start=-1.0, goal=0.0))
    return tmp_path


def planned(folder: Path, request: str) -> to.Result:
    scene = read_scene(folder / "scene.yaml", to.load(folder / "odd.urdf"))
    return to.plan(read_request(folder / request, scene).problem())


def test_results_and_plans_are_checked_and_exported(folder: Path) -> None:
    result = planned(folder, "request.yaml")
    result.write(folder / "result.json")
    result.require().write(str(folder / "plan.json"))
    assert json.loads((folder / "result.json").read_text())["counts"] == dict(result.counts)
    for name in ("result.json", "plan.json"):
        assert np.array_equal(read_trajectory(folder / name).positions, result.require().trajectory.positions)
        done = trajopt("check", *common(folder), folder / name)
        assert done.returncode == 0, done.stderr + done.stdout
        done = trajopt("export", folder / name, "--to", "csv", "--out", folder / "motion.csv")
        assert done.returncode == 0, done.stderr


def test_a_failure_is_written_and_read_as_one(folder: Path) -> None:
    result = planned(folder, "blocked.yaml")
    result.write(folder / "plan.json")
    assert json.loads((folder / "plan.json").read_text())["status"] == "GOAL_IN_COLLISION"
    with pytest.raises(FileFormatError, match="holds no motion: GOAL_IN_COLLISION"):
        read_trajectory(folder / "plan.json")
    with pytest.raises(ProblemError, match="path"):
        result.write(3)  # pyright: ignore
