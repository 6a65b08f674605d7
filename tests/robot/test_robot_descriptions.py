"""Robots of the package `robot_descriptions`, here one that stands in for it, are loaded by name."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import trajopt as to
from tests.conftest import PLANAR_ARM, PLANAR_ARM_SRDF
from trajopt.values.errors import MissingExtra, ModelError, RobotNotFound


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    package = tmp_path / "robot_descriptions"
    package.mkdir()
    (tmp_path / "arm.urdf").write_text(PLANAR_ARM)
    (tmp_path / "arm.srdf").write_text(PLANAR_ARM_SRDF)
    (package / "__init__.py").write_text("")
    (package / "planar_arm_description.py").write_text(
        f"URDF_PATH = {str(tmp_path / 'arm.urdf')!r}\nPACKAGE_PATH = {str(tmp_path)!r}\n"
    )
    (package / "hopper_mj_description.py").write_text("MJCF_PATH = 'hopper.xml'\n")
    for name in [name for name in sys.modules if name.split(".")[0] == "robot_descriptions"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield tmp_path
    for name in [name for name in sys.modules if name.split(".")[0] == "robot_descriptions"]:
        del sys.modules[name]


def test_a_description_is_loaded_by_name(folder: Path) -> None:
    robot = to.load("planar_arm_description", srdf=folder / "arm.srdf")
    assert robot.urdf_path == folder / "arm.urdf"
    assert robot.group("arm").joints == ("shoulder", "elbow")


@pytest.mark.usefixtures("folder")
def test_an_unknown_one_is_refused_with_near_matches() -> None:
    with pytest.raises(RobotNotFound, match="did you mean 'planar_arm_description'"):
        to.load("planer_arm_description")


@pytest.mark.usefixtures("folder")
def test_one_without_a_urdf_is_refused() -> None:
    with pytest.raises(ModelError, match=r"'hopper_mj_description'.*no URDF"):
        to.load("hopper_mj_description")


def test_without_the_package_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("trajopt.robot.load._PACKAGE", "no_robot_descriptions_here")
    with pytest.raises(MissingExtra, match="descriptions"):
        to.load("panda_description")
