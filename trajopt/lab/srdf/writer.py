"""SRDF as text, readable by `trajopt.robot.loading.srdf` and MoveIt."""

from collections.abc import Mapping, Sequence
from xml.etree import ElementTree

from trajopt.lab.srdf.groups import BASE_JOINT, ProposedGroup
from trajopt.robot.loading.srdf import EndEffector
from trajopt.values.errors.arguments import checked


@checked
def srdf_text(
    name: str,
    groups: Sequence[ProposedGroup],
    *,
    states: Mapping[tuple[str, str], Mapping[str, float]],
    end_effectors: Sequence[EndEffector],
    disabled: Mapping[tuple[str, str], str],
) -> str:
    """Write an SRDF.

    Args:
        name: Of the robot, as in its URDF.
        groups: Chains, grippers, the base on wheels, and groups that join others.
        states: Joint -> position [rad | m] by (group, state).
        end_effectors: The parent of each gripper.
        disabled: Reason by the two links of each unchecked pair.
    """
    root = ElementTree.Element("robot", name=name)
    for group in groups:
        if group.is_base:
            world = {"name": BASE_JOINT, "type": "planar", "parent_frame": "world", "child_link": group.tip}
            ElementTree.SubElement(root, "virtual_joint", world)
    for group in groups:
        _add_group(root, group)
    for (group_name, state), values in states.items():
        element = ElementTree.SubElement(root, "group_state", name=state, group=group_name)
        for joint, value in values.items():
            ElementTree.SubElement(element, "joint", name=joint, value=f"{value:.10g}")
    for effector in end_effectors:
        facts = {"name": effector.name, "parent_link": effector.parent_link, "group": effector.group}
        if effector.parent_group:
            facts["parent_group"] = effector.parent_group
        ElementTree.SubElement(root, "end_effector", facts)
    for (first, second), reason in disabled.items():
        ElementTree.SubElement(root, "disable_collisions", link1=first, link2=second, reason=reason)
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _add_group(root: ElementTree.Element, group: ProposedGroup) -> None:
    element = ElementTree.SubElement(root, "group", name=group.name)
    if group.parts:
        for part in group.parts:
            ElementTree.SubElement(element, "group", name=part)
    elif group.base:
        ElementTree.SubElement(element, "chain", base_link=group.base, tip_link=group.tip)
    else:
        for link in group.links:
            ElementTree.SubElement(element, "link", name=link)
        for joint in group.joints:
            ElementTree.SubElement(element, "joint", name=joint)
