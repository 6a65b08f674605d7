"""Planning groups: the joints that move together, as MoveIt's SRDF names them."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import pinocchio as pin

from trajopt.errors import FrameNotFound, GroupNotFound, JointNotFound, shown
from trajopt.model.description.pinocchio_model import joint_above, joint_frame_names, link_frame, link_names
from trajopt.model.description.srdf import GroupElement, Srdf
from trajopt.model.printed import in_number, in_short

ALL_JOINTS = "all"
"""Name of the group that a robot without SRDF groups gets."""


@dataclass(frozen=True)
class Group:
    """Joints that are planned together.

    Attributes:
        name: The group's name.
        joints: Its driven joints (no mimicking, passive or fixed one), in the tree's order.
        links: Links whose parent joint is in the group, or that the group lists.
        tip: Tip link of its chain; None if it is no single chain.
    """

    name: str
    joints: tuple[str, ...]
    links: tuple[str, ...]
    tip: str | None

    def __repr__(self) -> str:
        """Say name, joints and tip."""
        tip = f", tip {self.tip}" if self.tip else ""
        joints = f"{in_number(self.joints, 'joint')}{tip}: {', '.join(self.joints)}"
        return in_short(f"Group({shown(self.name)}, {joints})")


@dataclass(frozen=True)
class _Members:
    """Names of joints (fixed ones too) and of links: a link may be named like a joint."""

    joints: set[str] = field(default_factory=set[str])
    links: set[str] = field(default_factory=set[str])

    def update(self, other: "_Members") -> None:
        self.joints.update(other.joints)
        self.links.update(other.links)


def _chain(model: pin.Model, base: str, tip: str, group: str) -> _Members:
    """Return the joints and links between base and tip."""
    found = _Members()
    link = tip
    while link != base:
        found.links.add(link)
        joint = model.frames[model.frames[link_frame(model, link)].parentFrame]
        if joint.parentFrame == 0:
            raise FrameNotFound(f"base link (of group {group!r}, above {tip!r})", base, found.links)
        found.joints.add(joint.name)
        link = model.frames[joint.parentFrame].name
    found.links.add(base)
    return found


@dataclass(frozen=True, eq=False)
class _Tree:
    """The kinematic tree by names, and the SRDF's groups."""

    model: pin.Model
    srdf: Srdf
    joints: tuple[str, ...]
    links: tuple[str, ...]
    all_joints: frozenset[str]

    def members(self, element: GroupElement, seen: tuple[str, ...]) -> _Members:
        """Return the names of all joints and links of a group and its subgroups."""
        found = _Members()
        for base, tip in element.chains:
            self._check_links(element, (base, tip))
            found.update(_chain(self.model, base, tip, element.name))
        for joint in element.joints:
            if joint not in self.all_joints:
                raise JointNotFound(f"joint (in group {element.name!r})", joint, self.joints)
            found.joints.add(joint)
        self._check_links(element, element.links)
        for link in element.links:
            found.links.add(link)
            found.joints.add(joint_above(self.model, link))
        for name in element.subgroups:
            if name not in self.srdf.groups or name in seen:
                raise GroupNotFound(f"subgroup (in group {element.name!r})", name, self.srdf.groups)
            found.update(self.members(self.srdf.groups[name], (*seen, name)))
        return found

    def _check_links(self, element: GroupElement, links: tuple[str, ...]) -> None:
        for link in links:
            if link not in self.links:
                raise FrameNotFound(f"link (in group {element.name!r})", link, self.links)


def resolve_groups(model: pin.Model, srdf: Srdf, mimics: frozenset[str]) -> Mapping[str, Group]:
    """Resolve the groups of an SRDF against the kinematic tree.

    Args:
        model: Pinocchio's model.
        srdf: The semantic description.
        mimics: Names of mimicking joints, which no group drives.

    Returns:
        Groups by name; one group of all driven joints when the SRDF has none.

    Raises:
        FrameNotFound: If a chain or a group names an unknown link.
        JointNotFound: If a group or a named state names an unknown joint.
        GroupNotFound: If a group includes an unknown group, or a named state is of one.
    """
    groups = _resolved(model, srdf, mimics)
    joints = frozenset(joint_frame_names(model))
    for (group, state), values in srdf.states.items():
        if group not in groups:
            raise GroupNotFound("group", group, groups)
        for joint in values:
            if joint not in joints:
                raise JointNotFound(f"joint (in state {state!r})", joint, tuple(model.names[1:]))
    return groups


def _resolved(model: pin.Model, srdf: Srdf, mimics: frozenset[str]) -> Mapping[str, Group]:
    movable = tuple(model.names[1:])
    links = link_names(model)
    driven = tuple(joint for joint in movable if joint not in mimics | srdf.passive_joints)
    if not srdf.groups:
        return {ALL_JOINTS: Group(ALL_JOINTS, driven, links, links[-1])}
    tree = _Tree(model, srdf, movable, links, frozenset(joint_frame_names(model)))
    groups: dict[str, Group] = {}
    for name, element in srdf.groups.items():
        found = tree.members(element, (name,))
        groups[name] = Group(
            name,
            tuple(joint for joint in driven if joint in found.joints),
            tuple(link for link in links if link in found.links),
            element.chains[0][1] if len(element.chains) == 1 else None,
        )
    return groups
