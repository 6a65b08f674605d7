"""What there is to say of grippers: which joints are taken for theirs, and which may be."""

from collections.abc import Iterator, Sequence

from trajopt.lab.srdf.grippers import doubt
from trajopt.lab.srdf.groups import ProposedGroup
from trajopt.lab.srdf.link_tree import LinkTree
from trajopt.lab.srdf.urdf_checks import Finding, Severity
from trajopt.values.errors import listed, shown


def gripper_findings(tree: LinkTree, groups: Sequence[ProposedGroup]) -> Iterator[Finding]:
    """Say which joints the groups take for a gripper's, and which of an arm's may be one's."""
    carriers = {group.parent_group for group in groups}
    for group in groups:
        if group.is_gripper:
            one = "; name its open and closed states: one finger does not tell which end is which"
            yield Finding(
                Severity.NOTE,
                listed(group.driven),
                f"taken for a gripper's: in group {shown(group.name)}, and motions of "
                f"{shown(group.parent_group)} leave the gripper as it is at their start"
                f"{one if len(group.joints) == 1 else ''}",
            )
            continue
        joint, why = ("", "") if group.name in carriers else doubt(tree, group.driven)
        if joint:
            end = next(link.parent for link in tree.links.values() if link.joint == joint)
            yield Finding(
                Severity.NOTE,
                joint,
                f"may be a gripper's ({why}), but is in group {shown(group.name)}, whose motions move it: "
                f"if it is, let the group's chain end at {end}",
            )
