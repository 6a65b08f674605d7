"""Files written by hand, and the robots that the shared problem sets are about."""

from collections.abc import Callable
from pathlib import Path
from textwrap import dedent

import pytest

import trajopt as to
from trajopt.files.moveit import RequestFile, SceneFile, read_request, read_scene
from trajopt.values.errors import RobotNotFound


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    """Write YAML into a file."""

    def write_file(text: str, name: str = "file.yaml") -> Path:
        path = tmp_path / name
        path.write_text(dedent(text))
        return path

    return write_file


@pytest.fixture
def scene_of(write: Callable[..., Path], planar_arm: to.Robot) -> Callable[[str], SceneFile]:
    """Read a planning scene of the planar arm from its text."""
    return lambda text: read_scene(write(text, "scene.yaml"), planar_arm)


@pytest.fixture
def request_of(write: Callable[..., Path], planar_arm: to.Robot) -> Callable[..., RequestFile]:
    """Read a motion plan request of the planar arm from its text."""

    def read(text: str, scene: to.Scene | SceneFile | None = None) -> RequestFile:
        return read_request(write(text, "request.yaml"), scene or to.Scene(planar_arm))

    return read


@pytest.fixture(scope="session")
def panda() -> to.Robot:
    try:
        return to.load("panda")
    except RobotNotFound:  # not installed, but run from the source tree
        load = pytest.importorskip("robots.panda", reason="the Panda is neither installed nor here").load
        return load()


@pytest.fixture(scope="session")
def foreign_ur5(shared_data: Path) -> to.Robot:
    """The UR5 with gripper that the UR5 problems were made for."""
    folder = shared_data / "motionbenchmaker" / "ur5" / "robot"
    return to.Robot.from_urdf(folder / "ur5.urdf", srdf=folder / "ur5.srdf", package_dirs=(folder,))
