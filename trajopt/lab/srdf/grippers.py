"""Where an arm ends and its gripper begins on a chain without branches: by names, and by what is small."""

from collections.abc import Sequence

from trajopt.lab.srdf.link_tree import LinkTree, TreeLink
from trajopt.robot.loading.gripper_names import TURNS, names_fingers, names_gripper, words

ARM_JOINTS = 2
"""A chain with fewer driven joints is not an arm."""
GRIPPER_SHARE = 0.4
"""What comes at the end of an arm and reaches no farther than this share of the arm is a gripper."""


def gripper_start(tree: LinkTree, path: Sequence[str]) -> str:
    """Return the first link of a gripper at the end of a chain; empty if no name says that it has one.

    Args:
        tree: All links.
        path: Links of a chain from its base to its last moving link.
    """
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
    """Say whether the joint above a link is a gripper's by its name, its link's, or that of a fixed hand."""
    if names_fingers(link.joint, link.name):
        return True
    carrier = tree.links[link.parent]
    fixed_hand = bool(carrier.parent) and not carrier.moving and names_gripper(carrier.name)
    return fixed_hand and not words(link.joint) & TURNS


def doubt(tree: LinkTree, joints: Sequence[str]) -> tuple[str, str]:
    """Return the joint of a chain that may be a gripper's, and why; both empty if none looks like it.

    Args:
        tree: All links.
        joints: The chain's driven joints, from its base to its tip.
    """
    above = {link.joint: link for link in tree.links.values()}
    links = [above[joint] for joint in joints]
    if len(links) < ARM_JOINTS or all(opens(tree, link) for link in links):
        return "", ""
    last = links[-1]
    named = any(names_gripper(name) for name in (last.joint, last.name)) and not words(last.joint) & TURNS
    if named or opens(tree, last):
        return last.joint, "its name or that of a link beside it says so"
    behind_fixed = [link for link in links[1:] if not tree.links[link.parent].moving]
    if behind_fixed == [last]:
        return last.joint, f"{last.parent}, which it hangs on, is fixed to the link before"
    return "", ""
