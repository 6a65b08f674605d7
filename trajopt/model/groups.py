"""Planning groups: the joints that move together, as MoveIt's SRDF names them."""

from collections.abc import Mapping
from dataclasses import dataclass

import pinocchio as pin

from trajopt.errors import FrameNotFound, GroupNotFound, JointNotFound
from trajopt.model.srdf import GroupElement, Srdf

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


def _parent_joint_names(model: pin.Model, base: str, tip: str, group: str) -> list[str]:
    """List the joints (fixed ones too) and links between base and tip, tip first."""
    names: list[str] = []
    frame = model.frames[model.getFrameId(tip)]
    while frame.name != base:
        names.append(frame.name)
        if frame.parentFrame == 0 or frame.name == "universe":
            raise FrameNotFound(f"base link (of group {group!r}, above {tip!r})", base, names)
        frame = model.frames[frame.parentFrame]
    names.append(base)
    return names


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
        JointNotFound: If a group names an unknown joint.
        GroupNotFound: If a group includes an unknown group.
    """
    movable = tuple(model.names[1:])
    idle = mimics | srdf.passive_joints
    frame_names = {frame.name for frame in model.frames}
    links = [frame.name for frame in model.frames if frame.type == pin.FrameType.BODY]

    def members(element: GroupElement, seen: tuple[str, ...]) -> set[str]:
        found: set[str] = set()
        for base, tip in element.chains:
            for link in (base, tip):
                if link not in links:
                    raise FrameNotFound(f"link (in group {element.name!r})", link, links)
            found.update(_parent_joint_names(model, base, tip, element.name))
        for joint in element.joints:
            if joint not in frame_names:
                raise JointNotFound(f"joint (in group {element.name!r})", joint, movable)
            found.add(joint)
        for link in element.links:
            if link not in links:
                raise FrameNotFound(f"link (in group {element.name!r})", link, links)
            frame = model.frames[model.getFrameId(link)]
            found.update((link, model.frames[frame.parentFrame].name))
        for name in element.subgroups:
            if name not in srdf.groups or name in seen:
                raise GroupNotFound(f"subgroup (in group {element.name!r})", name, srdf.groups)
            found.update(members(srdf.groups[name], (*seen, name)))
        return found

    groups: dict[str, Group] = {}
    for name, element in srdf.groups.items():
        found = members(element, (name,))
        tip = element.chains[0][1] if len(element.chains) == 1 else None
        groups[name] = Group(
            name,
            tuple(joint for joint in movable if joint in found and joint not in idle),
            tuple(link for link in links if link in found),
            tip,
        )
    if not groups:
        groups[ALL_JOINTS] = Group(
            ALL_JOINTS, tuple(joint for joint in movable if joint not in idle), tuple(links), links[-1]
        )
    return groups
