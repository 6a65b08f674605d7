"""Joints of several degrees of freedom: expanded to simple joints, or fixed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import atan2
from typing import Any
from xml.etree import ElementTree

from trajopt.robot.bases import BaseJoint, Drive, MovingBase, RobotBase
from trajopt.robot.loading.srdf import FLOATING, PLANAR, GroupElement, Srdf, VirtualJoint
from trajopt.robot.loading.urdf import SEVERAL_DEGREES_OF_FREEDOM, Urdf
from trajopt.values.errors import GroupNotFound, JointNotFound, ModelError, shown
from trajopt.values.placement import WORLD

TO_MOVE_IT = "load the robot with base=to.bases.planar_base(...) for a base that moves in the plane"


@dataclass(frozen=True, eq=False)
class Based:
    """A robot's descriptions with joints of one degree of freedom only.

    Attributes:
        urdf: The URDF with the base's joints, and notes on fixed ones.
        limits: Limits of the URDF and of the base's joints, as in a `joint_limits.yaml`.
        base: The connection of the robot to the world.
    """

    urdf: Urdf
    srdf: Srdf
    limits: Mapping[str, Mapping[str, float]]
    base: RobotBase

    def limits_beside(self, stated: Mapping[str, Mapping[str, Any]]) -> Mapping[str, Mapping[str, Any]]:
        return {
            name: {**self.limits.get(name, {}), **stated.get(name, {})} for name in {**self.limits, **stated}
        }


def with_base(urdf: Urdf, srdf: Srdf, base: MovingBase | None) -> Based:
    """Expand joints of several degrees of freedom to chains of simple ones; fix them without a base."""
    root = ElementTree.fromstring(urdf.xml)
    inside = {
        joint.get("name", ""): joint
        for joint in root.findall("joint")
        if joint.get("type") in SEVERAL_DEGREES_OF_FREEDOM
    }
    children = {_child(joint) for joint in root.findall("joint")}
    bottom = next((n for link in root.findall("link") if (n := link.get("name", "")) not in children), "")
    virtual = next((joint for joint in srdf.virtual_joints if joint.child == bottom), None)
    known, frame = ("", "") if virtual is None else (virtual.name, virtual.frame)
    limits = dict(urdf.limits)
    moved: tuple[str, ...] = ()
    if base is not None:
        known = _stands_for(base, inside, virtual)
        moved = tuple(known + joint.suffix for joint in base.joints)
        for name, joint in zip(moved, base.joints, strict=True):
            limits[name] = {"max_acceleration": joint.acceleration}
        _check_free(root, moved)
        if known in inside:
            child = _child(inside[known])
            _replace_joint(root, inside.pop(known), base.joints, moved)
        else:
            child = bottom
            frame = _add_below(root, bottom, frame or WORLD, base.joints, moved)
        srdf = _in_groups(_expanded(srdf, known, moved, child), base, moved)
    notes: list[str] = []
    for name, joint in inside.items():
        notes.append(f"the {joint.get('type', '')} joint {shown(name)} does not move: {TO_MOVE_IT}")
        joint.set("type", "fixed")
    mounted = RobotBase(known, frame, moved)
    if base is not None:
        mounted = replace(mounted, drive=base.drive, drift=base.drift)
    return Based(
        replace(urdf, xml=ElementTree.tostring(root, encoding="unicode"), notes=(*urdf.notes, *notes)),
        srdf,
        limits,
        mounted,
    )


def _child(joint: ElementTree.Element) -> str:
    child = joint.find("child")
    return "" if child is None else child.get("link", "")


def _stands_for(
    base: MovingBase, inside: Mapping[str, ElementTree.Element], virtual: VirtualJoint | None
) -> str:
    known = {} if virtual is None else {virtual.name: virtual.kind}
    known |= {name: joint.get("type", "") for name, joint in inside.items()}
    free = [name for name, kind in known.items() if kind in SEVERAL_DEGREES_OF_FREEDOM]
    if base.name:
        if free and base.name not in known:
            raise JointNotFound("joint (that the base replaces)", base.name, known)
        return base.name
    if len(free) > 1:
        raise ModelError(f"base: name the joint that it replaces: {', '.join(map(shown, free))}")
    return next(iter(free or known), "base" if len(base.joints) > 1 else "rail")


def _check_free(root: ElementTree.Element, names: Sequence[str]) -> None:
    taken = {joint.get("name") for joint in root.findall("joint")}
    for name in names:
        if name in taken:
            raise ModelError(f"base: the URDF has a joint {shown(name)} already; give the base another name")


def _replace_joint(
    root: ElementTree.Element,
    joint: ElementTree.Element,
    joints: Sequence[BaseJoint],
    names: Sequence[str],
) -> None:
    parent, origin = joint.find("parent"), joint.find("origin")
    above = "" if parent is None else parent.get("link", "")
    root.remove(joint)
    _add_chain(root, joints, names, (above, _child(joint)), origin)


def _add_below(
    root: ElementTree.Element, bottom: str, frame: str, joints: Sequence[BaseJoint], names: Sequence[str]
) -> str:
    if bottom in (WORLD, frame):
        carried = f"{names[-1]}/link"
        for joint in root.findall("joint"):
            parent = joint.find("parent")
            if parent is not None and parent.get("link") == bottom:
                parent.set("link", carried)
        ElementTree.SubElement(root, "link", name=carried)
        _add_chain(root, joints, names, (bottom, carried), None)
        return bottom
    if any(link.get("name") == frame for link in root.findall("link")):
        raise ModelError(f"base: {shown(frame)} is the world by the SRDF, and a link of the URDF that moves")
    ElementTree.SubElement(root, "link", name=frame)
    _add_chain(root, joints, names, (frame, bottom), None)
    return frame


def _add_chain(
    root: ElementTree.Element,
    joints: Sequence[BaseJoint],
    names: Sequence[str],
    ends: tuple[str, str],
    origin: ElementTree.Element | None,
) -> None:
    above, last = ends
    for place, (joint, name) in enumerate(zip(joints, names, strict=True)):
        below = last if place == len(names) - 1 else f"{name}/link"
        if below != last:
            ElementTree.SubElement(root, "link", name=below)
        element = ElementTree.SubElement(root, "joint", name=name, type=joint.kind)
        if origin is not None and place == 0:
            element.append(origin)
        ElementTree.SubElement(element, "parent", link=above)
        ElementTree.SubElement(element, "child", link=below)
        ElementTree.SubElement(element, "axis", xyz=" ".join(map(repr, joint.axis)))
        ElementTree.SubElement(
            element,
            "limit",
            lower=repr(joint.lower),
            upper=repr(joint.upper),
            velocity=repr(joint.velocity),
            effort="0",
        )
        above = below


def _expanded(srdf: Srdf, name: str, moved: tuple[str, ...], child: str) -> Srdf:
    def element(group: GroupElement) -> GroupElement:
        brought = moved if name in group.joints or child in group.links else ()
        return replace(group, joints=(*brought, *(joint for joint in group.joints if joint != name)))

    states = dict(srdf.states)
    several = {key: dict(values) for key, values in srdf.several.items()}
    for key, values in several.items():
        found = _in_plane(values.get(name, ()))
        if found and len(moved) == PLANAR:
            del values[name]
            states[key] = {**states[key], **dict(zip(moved, found, strict=True))}
    return replace(
        srdf,
        groups={key: element(group) for key, group in srdf.groups.items()},
        states=states,
        several=several,
        virtual_joints=tuple(joint for joint in srdf.virtual_joints if joint.child != child),
        passive_joints=srdf.passive_joints - {name},
    )


def _in_plane(numbers: Sequence[float]) -> tuple[float, ...]:
    if len(numbers) == PLANAR:
        return tuple(numbers)
    if len(numbers) == FLOATING:
        x, y, _, qx, qy, qz, qw = numbers
        return x, y, atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz))
    return ()


def _in_groups(srdf: Srdf, base: MovingBase, moved: tuple[str, ...]) -> Srdf:
    groups = dict(srdf.groups)
    for name in base.groups:
        if name not in groups:
            raise GroupNotFound("group (that moves the base)", name, groups)
        others = tuple(joint for joint in groups[name].joints if joint not in moved)
        groups[name] = replace(groups[name], joints=(*moved, *others))
    if base.drive is Drive.DIFFERENTIAL:
        for name, group in groups.items():
            if 0 < len(set(moved) & set(group.joints)) < len(moved):
                reason = f"has some of {', '.join(moved)} only, but wheels that roll need all of them"
                raise ModelError(f"base: group {shown(name)} {reason}")
    if groups and not any(moved[0] in group.joints for group in groups.values()):
        raise ModelError(
            f"base: no group of the SRDF has its joints; name in `groups` which move it: {', '.join(groups)}"
        )
    return replace(srdf, groups=groups)
