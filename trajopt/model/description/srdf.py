"""SRDF: MoveIt's semantic description (groups, named states, end effectors, disabled pairs)."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

from trajopt.errors import FileFormatError
from trajopt.model.description.xml_file import numbers, read_xml

PLANAR, FLOATING = 3, 7
"""How many numbers MoveIt states of joints of several degrees of freedom."""
NUMBERS_OF_A_JOINT = (1, PLANAR, FLOATING)


@dataclass(frozen=True)
class GroupElement:
    """A `<group>` as written, before it is resolved against the kinematic tree.

    Attributes:
        name: The group's name.
        chains: (base link, tip link) pairs.
        joints: Joints listed by name.
        links: Links listed by name; each brings its parent joint.
        subgroups: Groups included by name.
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
    """A `<virtual_joint>`: how the robot hangs on the world.

    Attributes:
        name: The joint's name.
        kind: "fixed", "planar" or "floating".
        frame: What the file calls the world.
        child: The robot's link.
    """

    name: str
    kind: str
    frame: str
    child: str


@dataclass(frozen=True)
class Srdf:
    """What an SRDF file says.

    Attributes:
        groups: Group elements by name, in the file's order.
        states: Joint positions [rad | m] by (group, state) and joint, of joints with one number.
        several: The same of joints with several numbers: planar and floating ones.
        virtual_joints: Joints between the world and the robot.
        end_effectors: By name.
        disabled_pairs: Link pairs never checked for collision.
        passive_joints: Joints nobody drives.
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


def read_srdf(path: Path) -> Srdf:
    """Read an SRDF file.

    Raises:
        FileFormatError: If it is missing, no XML, or an element lacks what it must carry.
    """
    root = read_xml(path, "SRDF")

    def need(element: ElementTree.Element, key: str) -> str:
        value = element.get(key)
        if value is None:
            raise FileFormatError(str(path), f"<{element.tag}> has no attribute {key!r}")
        return value

    def names(group: ElementTree.Element, tag: str) -> tuple[str, ...]:
        return tuple(need(item, "name") for item in group.findall(tag))

    groups: dict[str, GroupElement] = {}
    for group in root.findall("group"):
        chains = tuple(
            (need(chain, "base_link"), need(chain, "tip_link")) for chain in group.findall("chain")
        )
        name = need(group, "name")
        groups[name] = GroupElement(
            name, chains, names(group, "joint"), names(group, "link"), names(group, "group")
        )
    states: dict[tuple[str, str], Mapping[str, float]] = {}
    several: dict[tuple[str, str], Mapping[str, tuple[float, ...]]] = {}
    for state in root.findall("group_state"):
        values: dict[str, tuple[float, ...]] = {}
        for joint in state.findall("joint"):
            need(joint, "value")
            values[need(joint, "name")] = tuple(numbers(path, joint, "value", ""))
            if len(values[need(joint, "name")]) not in NUMBERS_OF_A_JOINT:
                reason = f"state {need(state, 'name')}: {need(joint, 'name')} has no single number"
                raise FileFormatError(str(path), reason)
        key = need(state, "group"), need(state, "name")
        states[key] = {joint: found[0] for joint, found in values.items() if len(found) == 1}
        several[key] = {joint: found for joint, found in values.items() if len(found) > 1}
    virtual = tuple(
        VirtualJoint(
            need(item, "name"), need(item, "type"), item.get("parent_frame", ""), need(item, "child_link")
        )
        for item in root.findall("virtual_joint")
    )
    effectors = {
        need(item, "name"): EndEffector(
            need(item, "name"), need(item, "group"), need(item, "parent_link"), item.get("parent_group")
        )
        for item in root.findall("end_effector")
    }
    disabled = frozenset(
        frozenset((need(item, "link1"), need(item, "link2"))) for item in root.findall("disable_collisions")
    )
    passive = frozenset(names(root, "passive_joint"))
    return Srdf(groups, states, several, virtual, effectors, disabled, passive)
