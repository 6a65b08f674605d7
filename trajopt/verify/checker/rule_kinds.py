"""All kinds of requirements, and the rule of a waypoint."""

import copy
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import rule_joints
import rule_orientation
import rule_placement
import rule_region
import rule_tool_speed
import rule_torque
from kinematics import GridKinematics
from reading import Fields, demand, mapping, number, one_of, record, text
from requirement import Bools, StatedRequirement
from statement import Statement

Rule = Callable[[Fields, Statement], StatedRequirement]
OF_THE_END: Mapping[str, Rule] = {
    "joint positions": rule_joints.read,
    "frame placement": rule_placement.read,
    "axis alignment": rule_orientation.read,
    "position in region": rule_region.read,
}


ALWAYS: Mapping[str, Rule] = {
    "held placement": rule_placement.read_held,
    "gravity torque": rule_torque.read_gravity,
    "tool speed": rule_tool_speed.read,
    "angular speed": rule_orientation.read_speed,
}


def read_requirement(value: Fields, statement: Statement) -> StatedRequirement:
    others = {"torque": rule_torque.read, "cloud": rule_region.read_cloud, "rest": rule_joints.read_rest}
    others |= {"steady speed": rule_tool_speed.read_steady, "part": _part, "waypoint": _waypoint}
    return _read(value, statement, {**OF_THE_END, **ALWAYS, **others})


def _read(value: Fields, statement: Statement, rules: Mapping[str, Rule]) -> StatedRequirement:
    return rules[one_of(rules)("kind of a requirement", value.get("kind"))](value, statement)


def _part(value: Fields, statement: Statement) -> StatedRequirement:
    """Read the rule of a part of the motion: cells outside of it need not hold."""
    readers = {"kind": text, "since": number, "until": number, "requirement": mapping}
    _, since, until, inner = record("part", value, readers)
    fits = inner.get("always") is True or inner.get("kind") in list(ALWAYS)
    demand(fits, "the requirement of a part must be one of all times")
    required = _read(inner, statement, {**OF_THE_END, **ALWAYS})

    def holds(arm: GridKinematics) -> Bools:
        return required.holds(arm) | (arm.grid[1:] <= since) | (arm.grid[:-1] >= until)

    return StatedRequirement(
        required.words.replace("at all times", f"from {since:g} to {until:g} s", 1), holds
    )


def _waypoint(value: Fields, statement: Statement) -> StatedRequirement:
    """Read the rule: its moment is a time of the grid."""
    readers = {"kind": text, "name": text, "time": number, "requirement": mapping}
    _, name, time, inner = record("waypoint", value, readers)
    demand(not inner.get("always"), "the requirement of a waypoint must be one of the end")
    required = _read(inner, statement, OF_THE_END)

    def holds(arm: GridKinematics) -> Bools:
        count = int(np.count_nonzero(arm.grid <= time))
        if not count or arm.grid[count - 1] != time:
            return np.zeros(1, dtype=np.bool_)
        until = copy.copy(arm)
        until.grid = arm.grid[:count]
        until.rotation, until.translation = arm.rotation[:count], arm.translation[:count]
        until.motion = replace(arm.motion, positions=arm.motion.positions[:count])
        return required.holds(until)

    words = required.words.replace("at the end", f"at {time:.6g} s, waypoint {name}:", 1)
    return StatedRequirement(words, holds)
