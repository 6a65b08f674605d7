"""Files that trajopt wrote, given to its commands again."""

from pathlib import Path

import pytest

from tests.cli.process import trajopt
from tests.cli.test_commands import REQUEST, SCENE, common
from tests.robots_for_tests import ODD_ARM


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("read_back")
    (path / "odd.urdf").write_text(ODD_ARM)
    (path / "scene.yaml").write_text(SCENE)
    (path / "request.yaml").write_text(REQUEST.format(start=-1.0, goal=1.0))
    done = trajopt("plan", *common(path), "--out", path / "plan.json")
    assert done.returncode == 0, done.stderr + done.stdout
    return path


@pytest.mark.parametrize("name", ["ros2.yaml", "ros2-topic.json", "moveit.yaml", "csv.csv"])
def test_exports_are_checked_and_exported_again(folder: Path, name: str) -> None:
    first, second = folder / name, folder / f"again.{name}.csv"
    for file, out, to in ((folder / "plan.json", first, first.stem), (first, second, "csv")):
        done = trajopt("export", file, "--to", to, "--out", out)
        assert done.returncode == 0, done.stderr
    assert second.read_text().startswith("time,position_pan,position_reach,")
    done = trajopt("check", *common(folder), first)
    # A table holds samples, between which a quintic goes beyond the limits by a little, as the page says.
    assert done.returncode == (1 if name == "csv.csv" else 0), done.stderr + done.stdout
    assert "goal: joints" in done.stdout
    done = trajopt("view", first)
    assert done.returncode == 2 and "give --robot, --scene and --request" in done.stderr
