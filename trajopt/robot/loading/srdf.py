"""SRDF: MoveIt's semantic description (groups, named states, end effectors, disabled pairs)."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

from trajopt.robot.loading.xml_file import numbers, read_xml
from trajopt.values.errors import FileFormatError, shown

PLANAR, FLOATING = 3, 7
"""Numbers that MoveIt uses for joints of several degrees of freedom."""


@dataclass(frozen=True)
class GroupElement:
    """A `<group>` as written, before it is resolved against the kinematic tree.

    Attributes:
        chains: (base link, tip link) pairs.
        links: Links listed by name; each brings its parent joint.
    """

    name: str
    chains: tuple[tuple[str, str], ...]
    joints: tuple[str, ...]
    links: tuple[str, ...]
    subgroups: tuple[str, ...]


@dataclass(frozen=True)
class EndEffector:
    """An `<end_effector>`: the group that moves it, and the link it is fixed to."""

    name: str
    group: str
    parent_link: str
    parent_group: str | None


@dataclass(frozen=True)
class VirtualJoint:
    """A `<virtual_joint>`: the connection of the robot to the world.

    Attributes:
        kind: "fixed", "planar" or "floating".
        frame: The file's name of the world.
    """

    name: str
    kind: str
    frame: str
    child: str


@dataclass(frozen=True)
class Srdf:
    """The content of an SRDF file.

    Attributes:
        groups: Group elements by name, in the file's order.
        states: Joint positions [rad | m] by (group, state) and joint, of joints with one number.
        several: Likewise for joints with several numbers: planar and floating ones.
        left_out: The reason for each skipped named state, by its name.
    """

    groups: Mapping[str, GroupElement] = field(default_factory=dict[str, GroupElement])
    states: Mapping[tuple[str, str], Mapping[str, float]] = field(
        default_factory=dict[tuple[str, str], Mapping[str, float]]
    )
    several: Mapping[tuple[str, str], Mapping[str, tuple[float, ...]]] = field(
        default_factory=dict[tuple[str, str], Mapping[str, tuple[float, ...]]]
    )
    virtual_joints: tuple[VirtualJoint, ...] = ()
    end_effectors: Mapping[str, EndEffector] = field(default_factory=dict[str, EndEffector])
    disabled_pairs: frozenset[frozenset[str]] = frozenset()
    passive_joints: frozenset[str] = frozenset()
    left_out: Mapping[str, str] = field(default_factory=dict[str, str])
    robot: str = ""


def read_srdf(path: Path) -> Srdf:
    """Read an SRDF file."""
    root = read_xml(path, "SRDF")
    if root.find("link") is not None:
        raise FileFormatError(str(path), "is a URDF, not an SRDF: it describes links")
    groups = [_read_group(path, group) for group in root.findall("group")]
    effectors = [_read_end_effector(path, item) for item in root.findall("end_effector")]
    positions: dict[tuple[str, str], Mapping[str, tuple[float, ...]]] = {}
    left_out: dict[str, str] = {}
    for state in root.findall("group_state"):
        name, group = _need(path, state, "name"), state.get("group")
        found = _read_state(path, state)
        if group:
            positions[group, name] = found
        else:
            left_out[name] = "it names no group"
    return Srdf(
        groups={group.name: group for group in groups},
        states={
            key: {joint: at[0] for joint, at in found.items() if len(at) == 1}
            for key, found in positions.items()
        },
        several={
            key: {joint: at for joint, at in found.items() if len(at) > 1} for key, found in positions.items()
        },
        virtual_joints=tuple(_read_virtual_joint(path, item) for item in root.findall("virtual_joint")),
        end_effectors={effector.name: effector for effector in effectors},
        disabled_pairs=frozenset(
            frozenset((_need(path, item, "link1"), _need(path, item, "link2")))
            for item in root.findall("disable_collisions")
        ),
        passive_joints=frozenset(_names(path, root, "passive_joint")),
        left_out=left_out,
        robot=root.get("name", ""),
    )


def _need(path: Path, element: ElementTree.Element, key: str) -> str:
    value = element.get(key)
    if value is None:
        raise FileFormatError(str(path), f"<{element.tag}> has no attribute {key!r}")
    return value


def _names(path: Path, parent: ElementTree.Element, tag: str) -> tuple[str, ...]:
    return tuple(_need(path, item, "name") for item in parent.findall(tag))


def _read_group(path: Path, group: ElementTree.Element) -> GroupElement:
    return GroupElement(
        name=_need(path, group, "name"),
        chains=tuple(
            (_need(path, chain, "base_link"), _need(path, chain, "tip_link"))
            for chain in group.findall("chain")
        ),
        joints=_names(path, group, "joint"),
        links=_names(path, group, "link"),
        subgroups=_names(path, group, "group"),
    )


def _read_state(path: Path, state: ElementTree.Element) -> Mapping[str, tuple[float, ...]]:
    found: dict[str, tuple[float, ...]] = {}
    for joint in state.findall("joint"):
        name = _need(path, joint, "name")
        _need(path, joint, "value")
        found[name] = tuple(numbers(path, joint, "value", ""))
        if not found[name]:
            raise FileFormatError(str(path), f"state {shown(state.get('name'))}: {shown(name)} has no number")
    return found


def _read_virtual_joint(path: Path, item: ElementTree.Element) -> VirtualJoint:
    name, kind, child = (_need(path, item, key) for key in ("name", "type", "child_link"))
    return VirtualJoint(name, kind, item.get("parent_frame", ""), child)


def _read_end_effector(path: Path, item: ElementTree.Element) -> EndEffector:
    name, group, link = (_need(path, item, key) for key in ("name", "group", "parent_link"))
    return EndEffector(name, group, link, item.get("parent_group"))
