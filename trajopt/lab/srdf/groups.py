"""Proposed planning groups, arms and grippers, read from the link tree."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import takewhile

import numpy as np
import pinocchio as pin

from trajopt.robot.joints import joint_unit
from trajopt.robot.loading.groups import TURNS, names_fingers, names_gripper, words
from trajopt.robot.robot import Robot
from trajopt.values.errors.arguments import checked


@dataclass(frozen=True)
class TreeLink:
    """A link and the joint above it.

    Attributes:
        parent: The link above; empty for the root.
        driven: Whether it moves and mimics no other.
        length: Distance between the origins of both links at zero [m].
    """

    name: str
    parent: str
    joint: str
    moving: bool
    driven: bool
    slides: bool
    endless: bool
    length: float


@dataclass(frozen=True, eq=False)
class LinkTree:
    """All links of a robot by name, each after its parent, and the links below each."""

    links: Mapping[str, TreeLink]
    below: Mapping[str, tuple[str, ...]]

    @staticmethod
    def of(robot: Robot) -> "LinkTree":
        """Read the tree of a robot."""
        model, data = robot.model, robot.model.createData()
        pin.framesForwardKinematics(model, data, robot.configuration(np.zeros(len(robot.joint_names))))
        links: dict[str, TreeLink] = {}
        below: dict[str, list[str]] = {}
        for place, frame in enumerate(model.frames):
            if frame.type != pin.FrameType.BODY:
                continue
            joint = model.frames[frame.parentFrame]
            above = model.frames[joint.parentFrame]
            below[frame.name] = []
            if above.name not in links:
                links[frame.name] = TreeLink(frame.name, "", "", False, False, False, False, 0.0)
                continue
            apart = data.oMf[place].translation - data.oMf[joint.parentFrame].translation
            moving = joint.name in robot.joint_names
            driven = moving and joint.name not in robot.mimics
            slides = moving and joint_unit(model, joint.name) == "m"
            endless = moving and bool(np.isinf(robot.limits.upper[robot.index([joint.name])]).any())
            length = float(np.linalg.norm(apart))
            links[frame.name] = TreeLink(
                frame.name, above.name, joint.name, moving, driven, slides, endless, length
            )
            below[above.name].append(frame.name)
        return LinkTree(links, {name: tuple(children) for name, children in below.items()})

    def subtree(self, name: str) -> tuple[TreeLink, ...]:
        found = [self.links[name]]
        for child in self.below[name]:
            found.extend(self.subtree(child))
        return tuple(found)

    def moving_below(self, name: str) -> tuple[str, ...]:
        return tuple(child for child in self.below[name] if any(link.moving for link in self.subtree(child)))

    def extent(self, name: str) -> float:
        return self.links[name].length + max((self.extent(child) for child in self.below[name]), default=0.0)

    def joined(self, one: str, other: str, solid: frozenset[str]) -> bool:
        """Return whether two links are joined by a joint, or by joints with only body-less links between."""
        return other in self._neighbours_above(one, solid) or one in self._neighbours_above(other, solid)

    def _neighbours_above(self, name: str, solid: frozenset[str]) -> tuple[str, ...]:
        found: list[str] = []
        above = self.links[name].parent
        while above:
            found.append(above)
            if above in solid:
                break
            above = self.links[above].parent
        return tuple(found)


BASE, BASE_JOINT = "base", "world_joint"
"""Names of the group of a base on wheels, and of the joint between world and base."""
TOOL_FRAMES = ("tool0", "tcp", "tool", "flange", "ee_link")
"""Preferred names of a tip among links fixed to the last moving one."""


@dataclass(frozen=True, kw_only=True)
class ProposedGroup:
    """A group for an SRDF.

    Attributes:
        base: First link of its chain; empty for a gripper and for a base on wheels.
        tip: Last link of its chain; for a gripper the link that carries the fingers, for a base on wheels the
            link that the joint to the world moves.
        joints: Moving joints, including mimics.
        driven: Moving joints without mimics and without the joint between world and base.
        parent_link: For a gripper: the link that it is fixed to.
        parent_group: For a gripper: the arm that carries it.
        parts: Names of the groups that it joins; empty for a group with joints of its own.
    """

    name: str
    base: str
    tip: str
    links: tuple[str, ...]
    joints: tuple[str, ...]
    driven: tuple[str, ...]
    parent_link: str = ""
    parent_group: str = ""
    parts: tuple[str, ...] = ()

    @property
    def is_gripper(self) -> bool:
        """Whether it is an end effector."""
        return bool(self.parent_link)

    @property
    def is_base(self) -> bool:
        """Whether it is the base of a robot on wheels, which a planar joint moves."""
        return self.joints == (BASE_JOINT,)


@checked
def propose_groups(tree: LinkTree) -> tuple[ProposedGroup, ...]:
    """Propose chains and grippers, arms before their attachments, then arms joined with torso and base.

    A chain leads from the root, or from a branching link, to the next branch or to the end. A small branch at
    the end of an arm is a gripper; so are the last joints of a chain without a branch, if their names suggest
    it. A robot on wheels gets a planar joint to the world and groups with it; its wheels are in no group.
    """
    root = next(iter(tree.links))
    chains = [part for chain in _chains(tree, root) for part in _torso_apart(tree, chain)]
    groups = _named([chain for chain in chains if body_part(chain[0].driven) != WHEEL])
    groups += [_on_torso(arm, torso) for arm in _arms(groups) for torso in groups if _carries(torso, arm)]
    if not any(words(name) & WHEELS for name in tree.links):
        return tuple(groups)
    base = ProposedGroup(name=BASE, base="", tip=root, links=(), joints=(BASE_JOINT,), driven=())
    on_torso = [group for group in groups if group.name.endswith(f"_{TORSO}")]
    on_base = (
        replace(group, name=f"{group.name}_{BASE}", parts=(BASE, group.name))
        for group in on_torso or _arms(groups)
    )
    return (*groups, base, *on_base)


def _torso_apart(tree: LinkTree, chain: list[ProposedGroup]) -> list[list[ProposedGroup]]:
    """Part a lift from the arm on it; a waist that turns below one arm alone is a joint of the arm."""
    whole, *grippers = chain
    sliding = {link.joint for link in tree.links.values() if link.slides}
    lift = takewhile(lambda joint: joint in sliding and body_part([joint]) == TORSO, whole.driven)
    count = len(list(lift))
    if not 0 < count <= len(whole.driven) - ARM_JOINTS:
        return [chain]
    shoulder = next(link.name for link in tree.links.values() if link.joint == whole.driven[count - 1])
    first = whole.joints.index(whole.driven[count])
    torso = replace(whole, tip=shoulder, joints=whole.joints[:first], driven=whole.driven[:count])
    arm = replace(whole, base=shoulder, joints=whole.joints[first:], driven=whole.driven[count:])
    return [[torso], [arm, *grippers]]


def _arms(groups: Sequence[ProposedGroup]) -> list[ProposedGroup]:
    carriers = {group.parent_group for group in groups}
    chains = (group for group in groups if group.base)
    return [chain for chain in chains if chain.name in carriers or body_part(chain.driven) == ARM]


def _carries(torso: ProposedGroup, arm: ProposedGroup) -> bool:
    return torso.tip == arm.base and body_part(torso.driven) == TORSO


def _on_torso(arm: ProposedGroup, torso: ProposedGroup) -> ProposedGroup:
    return ProposedGroup(
        name=f"{arm.name}_{torso.name}",
        base=torso.base,
        tip=arm.tip,
        links=(),
        joints=(*torso.joints, *arm.joints),
        driven=(*torso.driven, *arm.driven),
    )


def _chains(tree: LinkTree, base: str) -> list[list[ProposedGroup]]:
    here, travelled, path = base, 0.0, [base]
    branches = tree.moving_below(base)
    while len(branches) == 1:
        path.extend(_way(tree, here, branches[0]))
        here = branches[0]
        travelled += tree.links[here].length
        branches = tree.moving_below(here)
    driven = tuple(tree.links[name].joint for name in path[1:] if tree.links[name].driven)
    small = bool(branches) and max(tree.extent(child) for child in branches) <= GRIPPER_SHARE * travelled
    if branches and len(driven) >= ARM_JOINTS and small:
        return [_arm_with_gripper(tree, path, branches)]
    first = "" if branches else gripper_start(tree, path)
    if first:
        return [_arm_with_gripper(tree, path[: path.index(first)], (first,))]
    tip = here if branches else _tip(tree, here)
    own = [[_chain(tree, base, tip, path)]] if driven else []
    # Each branch is a chain of its own, which begins at the link that they share.
    return own + [chain for child in branches for chain in _branch(tree, here, child)]


def _arm_with_gripper(tree: LinkTree, path: Sequence[str], fingers: Sequence[str]) -> list[ProposedGroup]:
    palm = path[-1]
    held = not tree.links[palm].moving and len(path) > 1
    carrier = tree.links[palm].parent if held else palm
    return [_chain(tree, path[0], carrier, path), _gripper(tree, palm, carrier, fingers)]


def _branch(tree: LinkTree, base: str, child: str) -> list[list[ProposedGroup]]:
    below = {**tree.below, base: (child,)}
    return _chains(LinkTree(tree.links, below), base)


def _way(tree: LinkTree, above: str, below: str) -> list[str]:
    found: list[str] = []
    while below != above:
        found.append(below)
        below = tree.links[below].parent
    return found[::-1]


def _tip(tree: LinkTree, last: str) -> str:
    fixed = [(link.name, depth) for depth, link in enumerate(tree.subtree(last))]
    for wanted in TOOL_FRAMES:
        for name, _ in fixed:
            if name.lower() == wanted or name.lower().endswith(f"_{wanted}"):
                return name
    name, children = last, tree.below[last]
    while len(children) == 1:
        name, children = children[0], tree.below[children[0]]
    return name


def _chain(tree: LinkTree, base: str, tip: str, path: Sequence[str]) -> ProposedGroup:
    joints = tuple(tree.links[name].joint for name in path[1:] if tree.links[name].moving)
    driven = tuple(tree.links[name].joint for name in path[1:] if tree.links[name].driven)
    return ProposedGroup(name="", base=base, tip=tip, links=(), joints=joints, driven=driven)


def _gripper(tree: LinkTree, palm: str, carrier: str, branches: Sequence[str]) -> ProposedGroup:
    subtrees = [tree.subtree(child) for child in branches]
    # A part that only turns without end, such as a motor's disc, is not a finger.
    fingers = [links for links in subtrees if any(link.moving and not link.endless for link in links)]
    below = [link for links in fingers or subtrees for link in links]
    return ProposedGroup(
        name="",
        base="",
        tip=palm,
        links=(*(() if carrier == palm else (palm,)), *(link.name for link in below)),
        joints=tuple(link.joint for link in below if link.moving),
        driven=tuple(link.joint for link in below if link.driven),
        parent_link=carrier,
    )


def _named(chains: Sequence[Sequence[ProposedGroup]]) -> list[ProposedGroup]:
    alone = sum(body_part(chain[0].driven) == ARM for chain in chains) == 1
    names = UniqueNames({})
    found: list[ProposedGroup] = []
    for chain, *grippers in chains:
        found.append(replace(chain, name=names.take(chain_name(chain.driven))))
        carrier = found[-1].name
        for gripper in grippers:
            name = names.take(gripper_name(gripper.tip, carrier, alone=alone))
            found.append(replace(gripper, name=name, parent_group=carrier))
    return found


GRIPPER_SHARE = 0.4
"""A branch at the end of an arm with at most this share of the arm's reach is a gripper."""


def gripper_start(tree: LinkTree, path: Sequence[str]) -> str:
    """Return the first link of a gripper on a path from a chain's base; empty if no name suggests one."""
    links = [tree.links[name] for name in path[1:]]
    moving = [link for link in links if link.moving]
    begin = len(moving)
    while begin and opens(tree, moving[begin - 1]):
        begin -= 1
    above, fingers = moving[:begin], moving[begin:]
    if sum(link.driven for link in above) < ARM_JOINTS or not any(link.driven for link in fingers):
        return ""
    first = fingers[0].name
    travelled = sum(link.length for link in links[: links.index(fingers[0])])
    return first if tree.extent(first) <= GRIPPER_SHARE * travelled else ""


def opens(tree: LinkTree, link: TreeLink) -> bool:
    if names_fingers(link.joint, link.name):
        return True
    carrier = tree.links[link.parent]
    fixed_hand = bool(carrier.parent) and not carrier.moving and names_gripper(carrier.name)
    return fixed_hand and not words(link.joint) & TURNS


def doubt(tree: LinkTree, joints: Sequence[str]) -> tuple[str, str]:
    """Return the joint of a chain that may be a gripper's, and why; both empty if none looks like it."""
    above = {link.joint: link for link in tree.links.values()}
    links = [above[joint] for joint in joints]
    if len(links) < ARM_JOINTS or all(opens(tree, link) for link in links):
        return "", ""
    last = links[-1]
    named = any(names_gripper(name) for name in (last.joint, last.name)) and not words(last.joint) & TURNS
    if named or opens(tree, last):
        return last.joint, "by its name or a neighbouring link's"
    behind_fixed = [link for link in links[1:] if not tree.links[link.parent].moving]
    if behind_fixed == [last]:
        return last.joint, f"{last.parent}, which it hangs on, is fixed to the link before"
    return "", ""


ARM, HAND, GRIPPER, TORSO, WHEEL = "arm", "hand", "gripper", "torso", "wheel"
BODY_PARTS: Mapping[str, frozenset[str]] = {
    "head": frozenset(("head", "neck")),
    TORSO: frozenset((TORSO, "waist", "spine")),
    "leg": frozenset(("leg", "hip", "thigh", "knee", "calf", "ankle", "foot")),
    "finger": frozenset(("finger", "thumb")),
}
"""Words in the names of joints by the part of the body that they move."""
WHEELS = frozenset((WHEEL, "caster"))
"""Words in the names of links and joints of a base on wheels."""
SIDES: Mapping[str, frozenset[str]] = {"left": frozenset(("left", "l")), "right": frozenset(("right", "r"))}
"""Words in the names of joints by the side of the body."""
GENERAL = frozenset(("joint", "joints", "link"))
"""Words in names of joints without information."""
ARM_JOINTS = 2
"""A chain with fewer driven joints is not an arm."""


@dataclass
class UniqueNames:
    """Names that are given once; a second one of the same name gets a number."""

    counts: dict[str, int]

    def take(self, name: str) -> str:
        self.counts[name] = self.counts.get(name, 0) + 1
        return name if self.counts[name] == 1 else f"{name}_{self.counts[name]}"


def body_part(joints: Sequence[str]) -> str:
    if any(words(joint) & WHEELS for joint in joints):
        return WHEEL
    for part, known in BODY_PARTS.items():
        if all(words(joint) & known for joint in joints):
            return part
    return ARM if len(joints) >= ARM_JOINTS else ""


def chain_name(joints: Sequence[str]) -> str:
    part = body_part(joints)
    for side, known in SIDES.items():
        if all(words(joint) & known for joint in joints):
            return f"{side}_{part}" if part else f"{side}_{_shared(joints, GENERAL | known) or 'joint'}"
    if part and part != ARM:
        return part
    prefix = _shared(joints, GENERAL | {ARM})
    return "_".join(each for each in (prefix, part) if each) or "joint"


def gripper_name(palm: str, carrier: str, *, alone: bool) -> str:
    kind = HAND if HAND in words(palm) else GRIPPER
    side = "" if alone else carrier.removesuffix(ARM).strip("_")
    return f"{side}_{kind}" if side else kind


def _shared(joints: Sequence[str], left_out: frozenset[str]) -> str:
    split = [joint.split("_") for joint in joints]
    columns = (
        zip(*(each[:-1] for each in split), strict=False) if len(split) > 1 else zip(*split, strict=True)
    )
    shared: list[str] = []
    for column in columns:
        if len(set(column)) > 1:
            break
        shared.append(column[0])
    return "_".join(word for word in shared if word.lower() not in left_out)
