"""`to.load("fanuc_moveit_config")` finds URDF, SRDF and joint limits of a robot."""

from pathlib import Path

import pytest

import trajopt as to
from tests.robots_for_tests import ODD_ARM
from trajopt.values.errors import FileFormatError, ModelError

SRDF = """<robot name="{name}"><group name="arm"><joint name="{joint}"/></group>
<group_state name="home" group="arm"><joint name="{joint}" value="0.2"/></group_state></robot>"""


def write_config(root: Path, key: str = "URDF") -> Path:
    """Write a description package and the package of its MoveIt configuration beside it."""
    described, configured = root / "planar_description", root / "planar_moveit_config"
    (described / "urdf").mkdir(parents=True)
    (configured / "config").mkdir(parents=True)
    (described / "package.xml").write_text("<package><name>planar_description</name></package>")
    (described / "urdf" / "planar.urdf").write_text(ODD_ARM)
    robot = to.load(described / "urdf" / "planar.urdf")
    (configured / ".setup_assistant").write_text(
        f"moveit_setup_assistant_config:\n  {key}:\n    package: planar_description\n"
        f"    relative_path: urdf/planar.urdf\n  {key.replace('URDF', 'SRDF').replace('urdf', 'srdf')}:\n"
        "    relative_path: config/planar.srdf\n"
    )
    (configured / "config" / "planar.srdf").write_text(
        SRDF.format(name=robot.name, joint=robot.joint_names[0])
    )
    (configured / "config" / "joint_limits.yaml").write_text(
        f"joint_limits:\n  {robot.joint_names[0]}: {{has_velocity_limits: true, max_velocity: 0.125}}\n"
    )
    return configured


@pytest.mark.parametrize("key", ["URDF", "urdf"])
def test_finds_the_files_that_the_setup_assistant_names(key: str, tmp_path: Path) -> None:
    robot = to.load(write_config(tmp_path, key))
    assert robot.groups["arm"].joints == robot.joint_names[:1]
    assert robot.limits.velocity[0] == 0.125
    assert ("arm", "home") in robot.states


def test_finds_the_only_urdf_of_a_description(tmp_path: Path) -> None:
    write_config(tmp_path)
    described = tmp_path / "planar_description"
    assert to.load(described).joint_names
    (described / "urdf" / "other.urdf").write_text(ODD_ARM)
    with pytest.raises(FileFormatError, match=r"several files \(urdf/other\.urdf, urdf/planar\.urdf\)"):
        to.load(described)


def test_reports_a_folder_without_a_robot(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match="without a URDF"):
        to.load(tmp_path)
    configured = write_config(tmp_path)
    (tmp_path / "planar_description" / "urdf" / "planar.urdf").unlink()
    with pytest.raises(FileFormatError, match=r"planar\.urdf"):
        to.load(configured)
    (configured / ".setup_assistant").write_text("nothing: 1")
    with pytest.raises(FileFormatError, match="moveit_setup_assistant_config"):
        to.load(configured)


def test_rejects_the_srdf_of_another_robot(tmp_path: Path) -> None:
    configured = write_config(tmp_path)
    (configured / "config" / "planar.srdf").write_text(SRDF.format(name="fanuc", joint="joint_1"))
    with pytest.raises(ModelError, match="robot, 'fanuc': its groups name joint_1, and odd has none"):
        to.load(configured)
