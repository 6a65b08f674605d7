"""Planning groups: the joints that move together, as MoveIt's SRDF names them."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import pinocchio as pin

from trajopt.robot.loading.pinocchio_model import (
    joint_above,
    joint_frame_names,
    link_frame,
    link_joint,
    link_names,
)
from trajopt.robot.loading.srdf import GroupElement, Srdf
from trajopt.values.errors import FrameNotFound, GroupNotFound, JointNotFound, NameNotFound, shown
from trajopt.values.printed import in_number, in_short

ALL_JOINTS = "all"
"""Group of a robot whose SRDF has none."""


@dataclass(frozen=True)
class Group:
    """Joints planned together.

    Attributes:
        joints: Its driven joints (no mimicking, passive or fixed one), in the tree's order.
        links: Links whose parent joint is in the group, or that the group lists.
        tip: Tip link of its chain; None if it is not a single chain.
    """

    name: str
    joints: tuple[str, ...]
    links: tuple[str, ...]
    tip: str | None

    def __repr__(self) -> str:
        tip = f", tip {self.tip}" if self.tip else ""
        named = f": {', '.join(self.joints)}" if self.joints else ""
        joints = f"{in_number(self.joints, 'joint')}{tip}{named}"
        return in_short(f"Group({shown(self.name)}, {joints})")


@dataclass(frozen=True)
class _Members:
    joints: set[str] = field(default_factory=set[str])
    links: set[str] = field(default_factory=set[str])

    def update(self, other: "_Members") -> None:
        self.joints.update(other.joints)
        self.links.update(other.links)


def _chain(model: pin.Model, base: str, tip: str, group: str) -> _Members:
    found = _Members()
    link = tip
    while link != base:
        found.links.add(link)
        joint = model.frames[model.frames[link_frame(model, link)].parentFrame]
        if joint.parentFrame == 0:
            raise FrameNotFound(f"base link (of group {shown(group)}, above {shown(tip)})", base, found.links)
        found.joints.add(joint.name)
        link = model.frames[joint.parentFrame].name
    found.links.add(base)
    return found


@dataclass(frozen=True, eq=False)
class _Tree:
    model: pin.Model
    srdf: Srdf
    joints: tuple[str, ...]
    links: tuple[str, ...]
    all_joints: frozenset[str]
    bases: frozenset[str]

    def members(self, element: GroupElement, seen: tuple[str, ...]) -> _Members:
        found = _Members()
        for base, tip in element.chains:
            self._check_links(element, (base, tip))
            found.update(_chain(self.model, base, tip, element.name))
        for joint in element.joints:
            if joint in self.bases:
                continue
            if joint not in self.all_joints:
                raise JointNotFound(f"joint (in group {shown(element.name)})", joint, self.joints)
            found.joints.add(joint)
            found.links.update(link for link in self.links if joint_above(self.model, link) == joint)
        self._check_links(element, element.links)
        for link in element.links:
            found.links.add(link)
            found.joints.add(joint_above(self.model, link))
        for name in element.subgroups:
            if name not in self.srdf.groups or name in seen:
                raise GroupNotFound(f"subgroup (in group {shown(element.name)})", name, self.srdf.groups)
            found.update(self.members(self.srdf.groups[name], (*seen, name)))
        return found

    def _check_links(self, element: GroupElement, links: tuple[str, ...]) -> None:
        for link in links:
            if link not in self.links:
                raise FrameNotFound(f"link (in group {shown(element.name)})", link, self.links)


def resolve_groups(
    model: pin.Model, srdf: Srdf, mimics: frozenset[str]
) -> tuple[Mapping[str, Group], Mapping[str, str], list[str]]:
    """Resolve the groups of an SRDF against the kinematic tree.

    A group with names that the robot does not have is skipped: the remaining joints would be another group.

    Args:
        mimics: Names of mimicking joints, which no group drives.

    Returns:
        Groups by name, one of all driven joints if the SRDF has none; the reasons for skipped groups, by
        name; and further notes.
    """
    movable = tuple(model.names[1:])
    links = link_names(model)
    driven = tuple(joint for joint in movable if joint not in mimics | srdf.passive_joints)
    bases = frozenset(joint.name for joint in srdf.virtual_joints)
    tree = _Tree(model, srdf, movable, links, frozenset(joint_frame_names(model)), bases)
    groups: dict[str, Group] = {}
    left_out: dict[str, str] = {}
    notes: list[str] = []
    for name, element in srdf.groups.items():
        try:
            found = tree.members(element, (name,))
        except NameNotFound as error:
            left_out[name] = str(error)
            continue
        if not found.joints and not found.links:
            still = ", ".join(joint for joint in element.joints if joint in bases)
            left_out[name] = f"nothing is in it but {still}, which does not move" if still else "it is empty"
            continue
        for base in bases.intersection(element.joints):
            notes.append(f"group {shown(name)} is without {shown(base)}, which does not move")
        groups[name] = Group(
            name,
            tuple(joint for joint in driven if joint in found.joints),
            tuple(link for link in links if link in found.links),
            element.chains[0][1] if len(element.chains) == 1 else None,
        )
    if not groups:
        groups[ALL_JOINTS] = Group(ALL_JOINTS, driven, links, _end_of_one_chain(model, driven, links))
    return groups, left_out, notes


def _end_of_one_chain(model: pin.Model, driven: tuple[str, ...], links: tuple[str, ...]) -> str | None:
    moved = {joint_above(model, link): link for link in links}
    moving = tuple(model.names[1:])
    fingers = {joint for joint in moving if names_fingers(joint, moved.get(joint, ""))}
    if fingers.isdisjoint(driven) or fingers.issuperset(driven):
        fingers = set[str]()  # none that opens and closes by itself, or nothing but a gripper
    last = 0
    for joint in moving:
        if joint not in fingers:
            number = int(model.getJointId(joint))
            if last not in list(model.supports[number]):
                return None
            last = number
    return [link for link in links if link_joint(model, link) == last][-1]


FINGERS = ("finger", "thumb", "jaw", "claw", "knuckle", "pincer")
"""Name parts of joints that open and close."""
WHOLE = "gripper"
"""Name parts of a whole gripper, which a wrist may turn."""
TURNS = frozenset(("wrist", "roll", "pitch", "yaw", "rotate", "rotation", "swivel"))
"""Name parts of a joint that turns a whole gripper."""


def words(name: str) -> frozenset[str]:
    """Return the words of a name like "left_hand" or "jointGripper", in lower case."""
    return frozenset(word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", name))


def names_fingers(joint: str, link: str) -> bool:
    """Return whether a joint opens and closes a gripper, by its name or the name of its link."""
    if any(part in joint.lower() for part in FINGERS):
        return True
    named = WHOLE in joint.lower() or any(part in link.lower() for part in FINGERS)
    return named and not words(joint) & TURNS


def names_gripper(link: str) -> bool:
    """Return whether a link is a gripper, a hand or a part of one, by its name."""
    return any(part in link.lower() for part in (WHOLE, *FINGERS)) or "hand" in words(link)
