"""Robots from their files: groups, states, limits, mimics, meshes, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import ODD_ARM, odd_arm
from trajopt.robot.loading.stated_limits import DEFAULT_ACCELERATION_TIME
from trajopt.values.errors import (
    FileFormatError,
    FrameNotFound,
    GroupNotFound,
    JointNotFound,
    MeshFileError,
    RobotNotFound,
    StateNotFound,
    UnsupportedJoint,
)

SRDF = """<robot name="odd">
  <group name="arm"><chain base_link="base" tip_link="tip"/></group>
  <group name="rotary"><joint name="pan"/><link name="fore"/></group>
  <group name="both"><group name="rotary"/><joint name="wrist"/></group>
  <group name="hand"><link name="finger"/></group>
  <group_state name="home" group="arm"><joint name="pan" value="0.5"/>
    <joint name="elbow" value="1"/></group_state>
  <end_effector name="tool" group="hand" parent_link="tip"/>
  <passive_joint name="reach"/>
  <disable_collisions link1="base" link2="tip" reason="Never"/>
</robot>
"""
LIMITS = """
joint_limits:
  pan: {has_velocity_limits: true, max_velocity: 1.5, has_acceleration_limits: true, max_acceleration: 4.0}
  elbow: {has_acceleration_limits: false, max_acceleration: 9.0, has_jerk_limits: true, max_jerk: 70}
"""


@pytest.fixture
def arm(tmp_path: Path) -> to.Robot:
    odd_arm(tmp_path)
    (tmp_path / "odd.srdf").write_text(SRDF)
    (tmp_path / "limits.yaml").write_text(LIMITS)
    return to.load(tmp_path / "odd.urdf", srdf=tmp_path / "odd.srdf", limits=tmp_path / "limits.yaml")


def test_groups(arm: to.Robot) -> None:
    assert arm.group("arm").joints == ("pan", "elbow", "wrist"), "a passive joint is not driven"
    assert arm.group("arm").tip == "tip"
    assert arm.group("rotary").joints == ("pan", "elbow"), "a link brings its parent joint"
    assert arm.group("both").joints == ("pan", "elbow", "wrist")
    assert arm.group("hand").joints == (), "a mimicking joint is not driven"
    assert arm.end_effectors["tool"].parent_link == "tip"


def test_states_fill_in_the_rest_and_mimics_follow(arm: to.Robot) -> None:
    positions = dict(zip(arm.joint_names, arm.positions("home"), strict=True))
    assert positions == pytest.approx({"pan": 0.5, "reach": 0, "elbow": 1, "wrist": 0, "follow": 0.2})


def test_limits_list_their_defaults(arm: to.Robot) -> None:
    limits = arm.limits
    place = {name: i for i, name in enumerate(arm.joint_names)}
    assert limits.velocity[place["pan"]] == 1.5 and limits.acceleration[place["pan"]] == 4.0
    assert limits.acceleration[place["elbow"]] == pytest.approx(2.5 / DEFAULT_ACCELERATION_TIME)
    assert limits.jerk[place["elbow"]] == 70.0
    assert any(note.startswith("elbow acceleration") for note in limits.defaulted)
    assert not any(note.startswith("pan ") for note in limits.defaulted)
    assert np.isinf(limits.lower[place["pan"]]) and np.isinf(limits.upper[place["pan"]])


def test_disabled_and_adjacent_pairs(arm: to.Robot) -> None:
    assert frozenset(("base", "tip")) in arm.disabled_pairs
    assert frozenset(("slide", "fore")) in arm.disabled_pairs
    assert frozenset(("slide", "tip")) not in arm.disabled_pairs


def test_continuous_joint_is_one_number(arm: to.Robot) -> None:
    q = arm.configuration(arm.positions({"pan": 7.0}))
    assert len(q) == arm.model.nq == arm.model.nv + 1
    assert q[:2] == pytest.approx([np.cos(7.0), np.sin(7.0)])


@pytest.mark.parametrize(
    ("call", "error", "near"),
    [
        (lambda arm: arm.group("arn"), GroupNotFound, "arm"),
        (lambda arm: arm.frame("tipp"), FrameNotFound, "tip"),
        (lambda arm: arm.positions({"elbo": 1.0}), JointNotFound, "elbow"),
        (lambda arm: arm.positions("hom"), StateNotFound, "home"),
    ],
)
def test_unknown_names_come_with_near_ones(arm: to.Robot, call: object, error: type, near: str) -> None:
    with pytest.raises(error, match=near):
        call(arm)  # pyright: ignore[reportCallIssue]


def write(folder: Path, old: str, new: str) -> Path:
    assert old in ODD_ARM
    path = folder / "bad.urdf"
    path.write_text(ODD_ARM.replace(old, new))
    return path


def test_invalid_robots_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UnsupportedJoint, match="prismatic"):
        to.load(write(tmp_path, 'name="pan" type="continuous"', 'name="pan" type="ball"'))
    box = '<box size="0.1 0.1 0.1"/>'
    with pytest.raises(MeshFileError, match=r"gone\.stl"):
        to.load(write(tmp_path, box, '<mesh filename="package://arm/gone.stl"/>'))
    with pytest.raises(FileFormatError, match="list of numbers"):
        to.load(write(tmp_path, box, '<box size="a b c"/>'))
    with pytest.raises(RobotNotFound, match="panda"):
        to.load("pnada")
    (tmp_path / "no.urdf").write_text("not xml")
    with pytest.raises(FileFormatError, match=r"no\.urdf"):
        to.load(tmp_path / "no.urdf")


@pytest.mark.parametrize("named", ["package://arm/meshes/cube.stl", "meshes/cube.stl", "absolute"])
def test_mesh_names(tmp_path: Path, named: str) -> None:
    package = tmp_path / "arm"
    (package / "meshes").mkdir(parents=True)
    (package / "urdf").mkdir()
    cube = package / "meshes" / "cube.stl"
    cube.write_text(tetrahedron())
    name = str(cube) if named == "absolute" else named
    path = package / "urdf" / "arm.urdf"
    path.write_text(
        ODD_ARM.replace('<box size="0.1 0.1 0.1"/>', f'<mesh filename="{name}" scale="0.1 0.1 0.1"/>')
    )
    robot = to.load(path)
    (body,) = (body for body in robot.bodies if body.owner == "base")
    assert np.ptp(body.shape.vertices, axis=0) == pytest.approx(0.1)  # pyright: ignore
    assert robot.mesh_notes == ("base: convex hull",)


def tetrahedron() -> str:
    """Return an STL of the corner of a unit cube."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    lines = ["solid t"]
    for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)):
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {x} {y} {z}" for x, y, z in corners[list(face)]]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid t"])


@pytest.mark.parametrize(
    ("name", "group", "joints", "tool"),
    [
        ("panda", "panda_arm", 7, "panda_hand_tcp"),
        ("ur5", "manipulator", 6, "tool0"),
        ("xarm7", "xarm7", 7, "link_eef"),
        ("planar2", "arm", 2, "tool"),
    ],
)
def test_installed_robots(name: str, group: str, joints: int, tool: str) -> None:
    try:
        robot = to.load(name)
    except to.MissingExtra as error:
        pytest.skip(str(error))
    assert robot.name == name
    assert len(robot.group(group).joints) == joints
    assert tool in robot.frame_names
    assert np.isfinite(robot.limits.take(robot.index(robot.group(group).joints)).acceleration).all()
    assert robot.bodies


def test_a_urdf_given_as_srdf_is_refused(tmp_path: Path) -> None:
    urdf = tmp_path / "arm.urdf"
    urdf.write_text('<robot name="arm"><link name="base"/></robot>')
    with pytest.raises(FileFormatError, match=r"arm\.urdf: is a URDF, not an SRDF"):
        to.load(urdf, srdf=urdf)
