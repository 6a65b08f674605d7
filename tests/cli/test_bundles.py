"""Bundles on the command line: written by plan, taken by check, simulate, export and replay."""

import json
from pathlib import Path

import pytest

from tests.cli.process import trajopt
from tests.cli.test_commands import REQUEST, SCENE, common
from tests.robots_for_tests import ODD_ARM
from trajopt.files.bundle import read_bundle


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bundle, whose robot, scene and request are no longer there."""
    path = tmp_path_factory.mktemp("kept")
    (path / "odd.urdf").write_text(ODD_ARM)
    (path / "scene.yaml").write_text(SCENE)
    (path / "request.yaml").write_text(REQUEST.format(start=-1.0, goal=1.0))
    done = trajopt("plan", *common(path), "--save", path / "kept.trajopt")
    assert done.returncode == 0, done.stderr + done.stdout
    assert f"written to {path / 'kept.trajopt'}" in done.stdout
    done = trajopt("plan", *common(path), "--out", path / "also.trajopt")
    assert done.returncode == 0, done.stderr + done.stdout
    assert read_bundle(path / "also.trajopt").problem.group, "it was JSON, which no command reads"
    for name in ("odd.urdf", "scene.yaml", "request.yaml"):
        (path / name).unlink()
    return path / "kept.trajopt"


def test_a_bundle_is_checked_and_exported_without_any_other_file(kept: Path) -> None:
    done = trajopt("check", kept)
    assert done.returncode == 0, done.stderr + done.stdout
    assert "goal: joints" in done.stdout
    done = trajopt("export", kept, "--to", "csv", "--out", kept.with_suffix(".csv"))
    assert done.returncode == 0, done.stderr
    done = trajopt("simulate", kept, "--json")
    assert done.returncode == 0 and json.loads(done.stdout)["files"] == []


def test_check_refuses_a_robot_beside_a_bundle(kept: Path) -> None:
    done = trajopt("check", "--robot", "planar2", kept)
    assert done.returncode == 2 and "contains the whole problem" in done.stderr


def test_replay_gives_the_same_answer(kept: Path) -> None:
    done = trajopt("replay", kept)
    assert done.returncode == 0, done.stderr + done.stdout
    assert "the same answer, to the last digit" in done.stdout
    done = trajopt("replay", kept, "--method", "chomp", "--json")
    assert done.returncode == 1 and not json.loads(done.stdout)["same"]


def test_files_of_other_formats_are_refused(kept: Path, tmp_path: Path) -> None:
    (tmp_path / "half.trajopt").write_bytes(kept.read_bytes()[:500])
    for command in ("check", "view", "replay", "simulate"):
        done = trajopt(command, tmp_path / "half.trajopt")
        assert done.returncode == 2 and "is not a bundle" in done.stderr
