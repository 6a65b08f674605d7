"""The part of an SRDF that matches the robot; the rest is skipped and noted."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import chain

import pinocchio as pin

from trajopt.robot.loading.base_joints import TO_MOVE_IT
from trajopt.robot.loading.groups import ALL_JOINTS, Group, names_fingers, resolve_groups
from trajopt.robot.loading.mimics import MIMIC_ERROR
from trajopt.robot.loading.pinocchio_model import joint_above, joint_frame_names, link_names
from trajopt.robot.loading.srdf import EndEffector, Srdf
from trajopt.robot.loading.urdf import Mimic
from trajopt.values.errors import ModelError, listed, shown


@dataclass(frozen=True)
class Semantics:
    """The part of an SRDF that matches the robot.

    Attributes:
        states: Joint positions [rad | m] by (group, state) and joint.
        left_out: The reason for each skipped group or named state, by its name.
    """

    groups: Mapping[str, Group]
    states: Mapping[tuple[str, str], Mapping[str, float]]
    end_effectors: Mapping[str, EndEffector]
    disabled_pairs: frozenset[frozenset[str]]
    left_out: Mapping[str, str]
    notes: tuple[str, ...]


def _check_robot(model: pin.Model, srdf: Srdf) -> None:
    groups = srdf.groups.values()
    named = {
        *(name for group in groups for name in (*group.joints, *group.links)),
        *(name for group in groups for ends in group.chains for name in ends),
    }
    if (
        srdf.robot != model.name
        and named
        and named.isdisjoint({*link_names(model), *joint_frame_names(model)})
    ):
        raise ModelError(
            f"the SRDF is of another robot, {shown(srdf.robot)}: its groups name {listed(sorted(named))}, "
            f"and {model.name} has none of them"
        )


def semantics_of(model: pin.Model, srdf: Srdf, mimics: Mapping[str, Mimic]) -> Semantics:
    """Return the part of an SRDF that matches the robot."""
    _check_robot(model, srdf)
    groups, missing, said = resolve_groups(model, srdf, frozenset(mimics))
    notes = [*_bases(srdf), *said]
    notes += [f"group {shown(name)} is left out: {reason}" for name, reason in missing.items()]
    if srdf.groups and len(missing) == len(srdf.groups):
        notes.append(f"no group of the SRDF is left: all joints are in one named {ALL_JOINTS!r}")
    if not srdf.groups.keys() - missing.keys():
        notes += _fingers(model, groups[ALL_JOINTS])
    states, stateless, said = _states(model, srdf, groups)
    notes += [*said, *_contradictions(states, mimics)]
    links = frozenset(link_names(model))
    effectors, said = _end_effectors(srdf, groups, links)
    notes += said
    joints = (*joint_frame_names(model), *(joint.name for joint in srdf.virtual_joints))
    notes += _strangers("disable_collisions", "link", chain.from_iterable(srdf.disabled_pairs), links)
    notes += _strangers("passive_joint", "joint", srdf.passive_joints, joints)
    return Semantics(
        groups=groups,
        states=states,
        end_effectors=effectors,
        disabled_pairs=frozenset(pair for pair in srdf.disabled_pairs if pair <= links),
        left_out={**stateless, **missing},
        notes=tuple(notes),
    )


def _fingers(model: pin.Model, group: Group) -> list[str]:
    moved = {joint_above(model, link): link for link in group.links}
    found = [joint for joint in group.joints if names_fingers(joint, moved.get(joint, ""))]
    if not found or len(found) == len(group.joints):
        return []
    return [
        f"no groups are named, so all joints are in group {shown(group.name)} and are planned together, "
        f"including likely joints of a gripper: {listed(found)}"
    ]


def _bases(srdf: Srdf) -> list[str]:
    return [
        f"the {joint.kind} joint {shown(joint.name)} between {joint.frame or 'the world'} and "
        f"{joint.child} does not move: the base is fixed in its place; {TO_MOVE_IT}"
        for joint in srdf.virtual_joints
        if joint.kind != "fixed"
    ]


def _states(
    model: pin.Model, srdf: Srdf, groups: Mapping[str, Group]
) -> tuple[Mapping[tuple[str, str], Mapping[str, float]], Mapping[str, str], list[str]]:
    joints = frozenset(joint_frame_names(model))
    found: dict[tuple[str, str], Mapping[str, float]] = {}
    several: dict[str, list[str]] = {}
    left_out, without = dict(srdf.left_out), list[str]()
    for (group, state), values in srdf.states.items():
        if group not in groups:
            left_out[state] = f"its group {shown(group)} is left out or is not there"
            continue
        found[group, state] = {joint: at for joint, at in values.items() if joint in joints}
        strangers = sorted(values.keys() - joints)
        if strangers:
            without.append(
                f"state {shown(state)} is without {listed(strangers)}: the robot has no such joint"
            )
        for joint in srdf.several.get((group, state), ()):
            several.setdefault(joint, []).append(state)
    notes = [f"state {shown(state)} is left out: {reason}" for state, reason in left_out.items()]
    for joint, names in several.items():
        notes.append(f"{joint} has no single number and is left out of the named states: {listed(names)}")
    return found, left_out, [*notes, *without]


def _end_effectors(
    srdf: Srdf, groups: Mapping[str, Group], links: frozenset[str]
) -> tuple[Mapping[str, EndEffector], list[str]]:
    found: dict[str, EndEffector] = {}
    notes: list[str] = []
    for name, item in srdf.end_effectors.items():
        lacking = [] if item.parent_link in links else [f"link {shown(item.parent_link)}"]
        lacking += [] if item.group in groups else [f"group {shown(item.group)}"]
        if lacking:
            notes.append(f"end effector {shown(name)} is left out: there is no {' and no '.join(lacking)}")
        else:
            found[name] = item
    return found, notes


def _contradictions(
    states: Mapping[tuple[str, str], Mapping[str, float]], mimics: Mapping[str, Mimic]
) -> list[str]:
    said: list[str] = []
    for (_, state), values in states.items():
        for joint, mimic in mimics.items():
            if joint not in values or mimic.source not in values:
                continue
            follows = mimic.multiplier * values[mimic.source] + mimic.offset
            if not abs(values[joint] - follows) <= MIMIC_ERROR:
                said.append(
                    f"state {shown(state)} puts {joint} at {values[joint]:g}, but it follows {mimic.source} "
                    f"to {follows:g}: it follows"
                )
    return said


def _strangers(tag: str, kind: str, named: Iterable[str], known: Iterable[str]) -> list[str]:
    strangers = sorted(set(named) - set(known))
    if not strangers:
        return []
    return [f"<{tag}> names {kind}s that the robot does not have: {listed(strangers)}"]
