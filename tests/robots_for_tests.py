"""Small robots written as URDF text, with joints of every kind."""

from collections.abc import Sequence
from pathlib import Path

from trajopt import Robot, bases, placement

ODD_ARM = """<robot name="odd">
  <link name="base"><collision><origin xyz="0 0 0.05"/><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <link name="turret"><inertial><origin xyz="0 0 0.1"/><mass value="2"/><inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 0.1"/><geometry><cylinder radius="0.04" length="0.2"/></geometry></collision></link>
  <link name="slide"><inertial><origin xyz="0.1 0 0"/><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0.15 0 0" rpy="0 1.5708 0"/><geometry><capsule radius="0.03" length="0.2"/></geometry></collision></link>
  <link name="fore"><inertial><origin xyz="0.1 0 0"/><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0.12 0 0"/><geometry><box size="0.2 0.05 0.04"/></geometry></collision></link>
  <link name="tip"><inertial><origin xyz="0.05 0 0"/><mass value="0.5"/><inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0.06 0 0"/><geometry><sphere radius="0.04"/></geometry></collision></link>
  <link name="finger"><inertial><mass value="0.1"/><inertia ixx="0.0001" iyy="0.0001" izz="0.0001" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.02 0.02 0.06"/></geometry></collision></link>
  <joint name="pan" type="continuous"><parent link="base"/><child link="turret"/><origin xyz="0 0 0.1"/><axis xyz="0 0 1"/><limit effort="80" velocity="2"/></joint>
  <joint name="reach" type="prismatic"><parent link="turret"/><child link="slide"/><origin xyz="0 0 0.2" rpy="0 -0.2 0.1"/><axis xyz="1 0 0"/><limit lower="0" upper="0.3" effort="90" velocity="0.6"/></joint>
  <joint name="elbow" type="revolute"><parent link="slide"/><child link="fore"/><origin xyz="0.3 0 0"/><axis xyz="0.2 1 -0.3"/><limit lower="-2.5" upper="2.5" effort="60" velocity="2.5"/></joint>
  <joint name="wrist" type="revolute"><parent link="fore"/><child link="tip"/><origin xyz="0.25 0 0"/><axis xyz="1 0 0.5"/><limit lower="-3" upper="3" effort="20" velocity="3"/></joint>
  <joint name="follow" type="revolute"><parent link="tip"/><child link="finger"/><origin xyz="0.12 0 0"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="5" velocity="3"/><mimic joint="wrist" multiplier="-0.5" offset="0.2"/></joint>
</robot>
"""
"""Continuous, prismatic, revolute about odd axes, and a mimicking joint."""


def odd_arm(folder: Path) -> Robot:
    """Write and load the odd arm; its one group is "all" with four joints."""
    path = folder / "odd.urdf"
    path.write_text(ODD_ARM)
    return Robot.from_urdf(path)


def _arm(side: str, y: float) -> str:
    links = "".join(
        f'<link name="{side}_{link}"><collision><origin xyz="0 0 0.1"/><geometry><box size="0.05 0.05 0.2"/>'
        "</geometry></collision></link>"
        for link in ("upper", "fore", "hand")
    )
    limit = '<limit lower="-2" upper="2" effort="10" velocity="1"/>'
    return (
        f'{links}<joint name="{side}_shoulder" type="revolute"><parent link="torso"/>'
        f'<child link="{side}_upper"/><origin xyz="0 {y} 0.3"/><axis xyz="1 0 0"/>{limit}</joint>'
        f'<joint name="{side}_elbow" type="revolute"><parent link="{side}_upper"/>'
        f'<child link="{side}_fore"/><origin xyz="0 0 0.25"/><axis xyz="0 1 0"/>{limit}</joint>'
        f'<joint name="{side}_wrist" type="fixed"><parent link="{side}_fore"/>'
        f'<child link="{side}_hand"/><origin xyz="0 0 0.25"/></joint>'
    )


def two_arms(folder: Path) -> Robot:
    """Write and load two arms of two joints on a torso: groups "left", "right" and "both"."""
    body = '<link name="torso"><collision><geometry><box size="0.1 0.3 0.6"/></geometry></collision></link>'
    (folder / "arms.urdf").write_text(
        f'<robot name="two_arms">{body}{_arm("left", 0.2)}{_arm("right", -0.2)}</robot>'
    )
    groups = "".join(
        f'<group name="{side}"><chain base_link="torso" tip_link="{side}_hand"/></group>'
        for side in ("left", "right")
    )
    both = '<group name="both"><group name="left"/><group name="right"/></group>'
    (folder / "arms.srdf").write_text(f'<robot name="two_arms">{groups}{both}</robot>')
    tool = ("right_hand", placement((0.0, 0.0, 0.2), rpy=(0.1, 0.0, 0.0)))
    return Robot.from_urdf(folder / "arms.urdf", srdf=folder / "arms.srdf", frames={"tool": tool})


def sliding_base(folder: Path) -> Robot:
    """Write and load a base that slides and turns without limits, with a mast of two joints: one group, "all"."""
    links = "".join(
        f'<link name="{link}"/>'
        if size is None
        else f'<link name="{link}"><collision><origin xyz="0 0 {z}"/><geometry><box size="{size}"/></geometry></collision></link>'
        for link, size, z in (
            ("floor", None, 0),
            ("across", None, 0),
            ("along", None, 0),
            ("base", "0.8 0.6 0.4", 0.3),
            ("mast", "0.1 0.1 0.4", 0.3),
            ("boom", "0.4 0.05 0.05", 0),
        )
    )
    endless = '<limit lower="-1e6" upper="1e6" effort="500" velocity="1"/>'
    turns = '<limit lower="-2" upper="2" effort="100" velocity="1"/>'
    joints = (
        ("x", "prismatic", "floor", "across", "0 0 0", "1 0 0", endless),
        ("y", "prismatic", "across", "along", "0 0 0", "0 1 0", endless),
        ("yaw", "continuous", "along", "base", "0 0 0", "0 0 1", '<limit effort="100" velocity="1"/>'),
        ("swing", "revolute", "base", "mast", "0 0 0.5", "0 0 1", turns),
        ("lift", "revolute", "mast", "boom", "0.3 0 0.4", "0 1 0", turns),
    )
    return Robot.from_urdf(_written(folder / "base.urdf", links, joints))


def wheeled_base(folder: Path, reach: float = 12.0) -> Robot:
    """Write and load a base on two driven wheels with a boom of one joint: one group, "all"."""
    links = "".join(
        f'<link name="{link}"><collision><origin xyz="0 0 0.3"/>{shape}</collision></link>'
        for link, shape in (
            ("body", '<geometry><cylinder radius="0.3" length="0.5"/></geometry>'),
            ("boom", '<geometry><box size="0.4 0.05 0.05"/></geometry>'),
        )
    )
    turns = '<limit lower="-2" upper="2" effort="100" velocity="1"/>'
    path = _written(
        folder / "wheels.urdf", links, [("lift", "revolute", "body", "boom", "0 0 0.5", "0 1 0", turns)]
    )
    srdf = folder / "wheels.srdf"
    srdf.write_text(
        '<robot name="wheels"><virtual_joint name="world_joint" type="planar" parent_frame="map" child_link="body"/>'
        '<group name="all"><joint name="world_joint"/><joint name="lift"/></group></robot>'
    )
    base = bases.planar_base(
        (-reach, -reach),
        (reach, reach),
        velocity=(0.8, 1.0),
        acceleration=(0.8, 1.5),
        drive=bases.Drive.DIFFERENTIAL,
    )
    return Robot.from_urdf(path, srdf=srdf, base=base)


def _written(path: Path, links: str, joints: Sequence[tuple[str, ...]]) -> Path:
    path.write_text(
        f'<robot name="{path.stem}">{links}'
        + "".join(
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{at}"/><axis xyz="{axis}"/>{limit}</joint>'
            for name, kind, parent, child, at, axis, limit in joints
        )
        + "</robot>"
    )
    return path
