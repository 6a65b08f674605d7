"""Every robot of example-robot-data has a description that is read, with each SRDF beside it or with none."""

import sysconfig
from importlib import metadata
from pathlib import Path

import pytest

import trajopt as to
import trajopt.robot.robot
from trajopt.robot.bodies import RobotBodies
from trajopt.values.errors import FileFormatError

NOT_A_ROBOT = {"ur_description/urdf/ur3.urdf": "has no <link>, so it describes no robot"}


def robots_folder() -> Path:
    """Return the folder of the robots; an empty one's name where the package is not installed."""
    try:
        found = metadata.distribution("example-robot-data").locate_file("cmeel.prefix/share")
    except metadata.PackageNotFoundError:
        found = Path(sysconfig.get_path("data")) / "share"
    return Path(str(found)) / "example-robot-data" / "robots"


ROBOTS = robots_folder()
URDFS = [str(file.relative_to(ROBOTS)) for file in sorted(ROBOTS.rglob("*.urdf"))]


@pytest.fixture
def bare(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out what covers the meshes: it takes longer than all else, and is tested elsewhere."""

    def no_bodies(*_: object) -> RobotBodies:
        return RobotBodies((), (), ())

    monkeypatch.setattr(trajopt.robot.robot, "robot_bodies", no_bodies)


@pytest.mark.skipif(not URDFS, reason="example-robot-data is not installed")
def test_all_of_them_are_here() -> None:
    assert len(URDFS) == 69


@pytest.mark.usefixtures("bare")
@pytest.mark.parametrize("name", URDFS)
def test_a_description_is_read(name: str) -> None:
    package = ROBOTS / Path(name).parts[0]
    for srdf in (None, *sorted(package.rglob("*.srdf"))):
        if name in NOT_A_ROBOT:
            with pytest.raises(FileFormatError, match=NOT_A_ROBOT[name]):
                to.load(ROBOTS / name, srdf=srdf)
            continue
        robot = to.load(ROBOTS / name, srdf=srdf, package_dirs=[ROBOTS.parents[1]])
        assert robot.groups
        for group, reason in robot.left_out.items():
            assert reason and (group in robot.groups or any(repr(group) in note for note in robot.notes))
        for group, state in robot.states:
            assert set(robot.state(state, group=group)) <= set(robot.joint_names)
        positions = robot.positions()
        assert robot.configuration(positions).shape == (robot.model.nq,)
