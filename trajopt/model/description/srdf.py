"""SRDF: MoveIt's semantic description (groups, named states, end effectors, disabled pairs)."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

from trajopt.errors import FileFormatError
from trajopt.model.description.xml_file import numbers, read_xml


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
class Srdf:
    """What an SRDF file says.

    Attributes:
        groups: Group elements by name, in the file's order.
        states: Joint positions [rad | m] by (group, state) and joint.
        end_effectors: By name.
        disabled_pairs: Link pairs never checked for collision.
        passive_joints: Joints nobody drives.
    """

    groups: Mapping[str, GroupElement] = field(default_factory=dict[str, GroupElement])
    states: Mapping[tuple[str, str], Mapping[str, float]] = field(
        default_factory=dict[tuple[str, str], Mapping[str, float]]
    )
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
    for state in root.findall("group_state"):
        values: dict[str, float] = {}
        for joint in state.findall("joint"):
            need(joint, "value")
            found = numbers(path, joint, "value", "")
            if len(found) != 1:
                reason = f"state {need(state, 'name')}: {need(joint, 'name')} has no single number"
                raise FileFormatError(str(path), reason)
            values[need(joint, "name")] = found[0]
        states[need(state, "group"), need(state, "name")] = values
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
    return Srdf(groups, states, effectors, disabled, passive)
