"""Meshes of ROS packages are found where ROS looks for them, and xacro is expanded."""

from pathlib import Path

import pytest

import trajopt as to
from tests.robot.test_junk_descriptions import tetrahedron
from trajopt.values.errors import FileFormatError, MeshFileError, MissingExtra
from trajopt.values.shapes.shapes import Box

ROBOT = (
    '<robot name="arm"><link name="base"><collision><geometry><mesh filename="{}"/></geometry></collision>'
    '</link><link name="tip"/><joint name="j" type="continuous"><parent link="base"/><child link="tip"/>'
    "</joint></robot>"
)


def package(folder: Path, name: str, mesh: str = "meshes/a.stl") -> Path:
    """Make a folder a ROS package of a name, with a mesh in it."""
    (folder / mesh).parent.mkdir(parents=True)
    (folder / mesh).write_text(tetrahedron())
    (folder / "package.xml").write_text(f'<package format="3"><name> {name} </name></package>')
    return folder


def robot_with(folder: Path, mesh: str) -> Path:
    """Write a robot whose one mesh has this name."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "arm.urdf").write_text(ROBOT.format(mesh))
    return folder / "arm.urdf"


@pytest.fixture(autouse=True)
def no_ros(monkeypatch: pytest.MonkeyPatch) -> None:
    """Be on a machine without ROS."""
    for name in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)


def test_a_package_is_found_by_the_name_that_it_states_and_not_by_its_folder(tmp_path: Path) -> None:
    folder = package(tmp_path / "panda_description", "moveit_resources_panda_description")
    urdf = robot_with(folder / "urdf", "package://moveit_resources_panda_description/meshes/a.stl")
    assert to.load(urdf).mesh_notes


def test_a_name_with_three_slashes_is_searched_below_the_parent_folders(tmp_path: Path) -> None:
    package(tmp_path / "share" / "arm_data", "arm_data")
    urdf = robot_with(tmp_path / "share" / "arm_data" / "robots", "package:///share/arm_data/meshes/a.stl")
    assert to.load(urdf).mesh_notes


def test_finds_a_package_beside_the_package_of_the_description(tmp_path: Path) -> None:
    package(tmp_path / "src" / "panda_description", "moveit_resources_panda_description")
    folder = package(tmp_path / "src" / "panda_config", "moveit_resources_panda_config", "config/b.stl")
    urdf = robot_with(folder / "config", "package://moveit_resources_panda_description/meshes/a.stl")
    assert to.load(urdf).mesh_notes


@pytest.mark.parametrize("given", ["", "panda_description"])
def test_a_package_is_found_below_a_package_directory(tmp_path: Path, given: str) -> None:
    package(tmp_path / "elsewhere" / "panda_description", "moveit_resources_panda_description")
    urdf = robot_with(tmp_path / "robot", "package://moveit_resources_panda_description/meshes/a.stl")
    assert to.load(urdf, package_dirs=[tmp_path / "elsewhere" / given]).mesh_notes


@pytest.mark.parametrize("entry", ["ros", "ros/described", "nowhere:{0}/ros"])
def test_finds_a_package_on_the_ros_1_package_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, entry: str
) -> None:
    package(tmp_path / "ros" / "described", "arm_description")
    urdf = robot_with(tmp_path / "robot", "package://arm_description/meshes/a.stl")
    with pytest.raises(MeshFileError, match="ROS_PACKAGE_PATH and AMENT_PREFIX_PATH are not set"):
        to.load(urdf)
    path = entry.format(tmp_path) if "{" in entry else str(tmp_path / entry)
    monkeypatch.setenv("ROS_PACKAGE_PATH", path)
    assert to.load(urdf).mesh_notes


def test_a_package_is_found_where_ros_2_installs_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package(tmp_path / "install" / "share" / "arm_description", "arm_description")
    urdf = robot_with(tmp_path / "robot", "package://arm_description/meshes/a.stl")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path}/none:{tmp_path}/install")
    assert to.load(urdf).mesh_notes


def test_a_missing_mesh_error_lists_the_searched_folders(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    urdf = robot_with(tmp_path / "robot", "package://arm_description/meshes/a.stl")
    given = tmp_path / "given"
    with pytest.raises(MeshFileError) as caught:
        to.load(urdf, package_dirs=[given])
    said = str(caught.value)
    for part in (
        "package://arm_description/meshes/a.stl",
        str(given),
        str(tmp_path / "robot"),
        "package.xml",
    ):
        assert part in said
    assert "in AMENT_PREFIX_PATH (ROS_PACKAGE_PATH is not set)" in said


def test_a_package_path_cannot_leave_its_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package(tmp_path / "ros" / "arm", "arm_description")
    (tmp_path / "secret.stl").write_text(tetrahedron())
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ros"))
    folder = tmp_path / "ws" / "robot" / "urdf"
    inside = robot_with(folder, "package://arm_description/urdf/../meshes/a.stl")
    assert to.load(inside).mesh_notes
    with pytest.raises(MeshFileError, match="lies outside"):
        to.load(robot_with(folder, "package://arm_description/../../secret.stl"))


def test_ignores_a_package_file_without_a_valid_name(tmp_path: Path) -> None:
    folder = package(tmp_path / "described", "arm_description")
    urdf = robot_with(folder / "urdf", "package://arm_description/meshes/a.stl")
    for text in ("<package", "<robot/>", "<package/>", "<package><name/></package>"):
        (folder / "package.xml").write_text(text)
        with pytest.raises(MeshFileError, match="not found"):
            to.load(urdf)


LIMB = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="limb" params="name parent length">
    <link name="${name}"><collision><geometry><box size="${length} 0.1 0.1"/></geometry></collision></link>
    <joint name="${name}_joint" type="revolute"><parent link="${parent}"/><child link="${name}"/>
      <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="10" velocity="1"/></joint>
  </xacro:macro>
</robot>"""
XACRO = """<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="length" default="0.5"/>
  <xacro:include filename="$(find limb_macros)/meshes/limb.xacro"/>
  <xacro:include filename="hand.xacro"/>
  <link name="base"/>
  <xacro:limb name="upper" parent="base" length="$(arg length)"/>
  <xacro:limb name="fore" parent="upper" length="${2 * 0.1}"/>
</robot>"""
HAND = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="hand"/>
  <joint name="wrist" type="fixed"><parent link="fore"/><child link="hand"/></joint></robot>"""


def written_in_xacro(folder: Path) -> Path:
    """Write an arm in xacro, of macros in a package beside its own and a file beside itself."""
    own = package(folder / "src" / "arm", "arm_description")
    macros = package(folder / "src" / "shapes", "limb_macros")
    (macros / "meshes" / "limb.xacro").write_text(LIMB)
    (own / "urdf").mkdir()
    (own / "urdf" / "hand.xacro").write_text(HAND)
    (own / "urdf" / "arm.urdf.xacro").write_text(XACRO)
    return own / "urdf" / "arm.urdf.xacro"


def test_xacro_is_expanded_if_xacrodoc_is_installed(tmp_path: Path) -> None:
    pytest.importorskip("xacrodoc")
    file = written_in_xacro(tmp_path)
    for robot, length in ((to.load(file), 0.5), (to.Robot.from_urdf(file, xacro={"length": "0.8"}), 0.8)):
        assert robot.links == ("base", "upper", "fore", "hand")
        assert robot.joint_names == ("upper_joint", "fore_joint")
        assert [body.shape for body in robot.bodies] == [Box(length, 0.1, 0.1), Box(0.2, 0.1, 0.1)]
    file.write_text(XACRO.replace("2 * 0.1", "2 * nothing"))
    with pytest.raises(FileFormatError, match=r"arm\.urdf\.xacro: cannot be expanded by xacro.*nothing"):
        to.load(file)
    file.write_text(XACRO.replace("limb_macros", "no_such_package"))
    with pytest.raises(FileFormatError, match="no_such_package"):
        to.load(file)


def test_xacro_finds_a_folder_of_a_package_directory_by_its_name(tmp_path: Path) -> None:
    pytest.importorskip("xacrodoc")
    file = written_in_xacro(tmp_path)
    shapes = tmp_path / "src" / "shapes"
    (shapes / "package.xml").unlink()
    with pytest.raises(FileFormatError, match="limb_macros"):
        to.load(file)
    copied = shapes.rename(tmp_path / "limb_macros")
    for folder in (copied, tmp_path):
        assert to.load(file, package_dirs=[folder]).joint_names == ("upper_joint", "fore_joint")


def test_missing_xacrodoc_is_reported_with_the_install_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("trajopt.robot.loading.xml_file.find_spec", lambda _: None)
    with pytest.raises(MissingExtra, match=r'pip install "trajopt-planner\[xacro\]"'):
        to.load(written_in_xacro(tmp_path))
