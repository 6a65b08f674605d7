"""Joint limits in files such as MoveIt's `joint_limits.yaml`, and defaults for missing ones."""

from collections.abc import Collection, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np

from trajopt.robot.joints import PER_SECOND, JointLimits, LimitKind
from trajopt.values.arrays import Floats, readonly
from trajopt.values.documents.document import Node, read_document
from trajopt.values.errors import JointNotFound, ModelError, shown
from trajopt.values.printed import in_unit

DEFAULT_ACCELERATION_TIME = 0.5
"""Time in which a joint without an acceleration limit reaches its velocity limit [s]."""
_COLUMNS: Mapping[str, tuple[str, ...]] = {
    "has_velocity_limits": ("max_velocity",),
    "has_acceleration_limits": ("max_acceleration",),
    "has_jerk_limits": ("max_jerk",),
    "has_effort_limits": ("max_effort",),
    "has_position_limits": ("min_position", "max_position"),
}
_LIMITS = frozenset(key for keys in _COLUMNS.values() for key in keys)
_OTHERS = frozenset(
    (
        "has_deceleration_limits",
        "max_deceleration",
        "min_velocity",
        "min_acceleration",
        "min_jerk",
        "min_effort",
    )
)
"""Keys of MoveIt and ros2_control that have no effect and resemble others."""
_LARGEST = 1e300  # beyond it sums of limits overflow
DEFAULT_VELOCITY = 1.0
"""Velocity limit [rad/s | m/s] of a joint whose description has none."""


def with_stated(
    limits: JointLimits,
    stated: Mapping[str, Mapping[str, Any]],
    *,
    units: Mapping[str, str],
    mimics: Collection[str] = (),
) -> JointLimits:
    """Apply the entries of a `joint_limits.yaml`, and defaults for missing limits.

    A mimic joint without stated limits has none.
    """
    columns: dict[str, tuple[tuple[str, Floats], ...]] = {
        "has_velocity_limits": (("max_velocity", np.array(limits.velocity)),),
        "has_acceleration_limits": (("max_acceleration", np.array(limits.acceleration)),),
        "has_jerk_limits": (("max_jerk", np.array(limits.jerk)),),
        "has_effort_limits": (("max_effort", np.array(limits.effort)),),
        "has_position_limits": (
            ("min_position", np.array(limits.lower)),
            ("max_position", np.array(limits.upper)),
        ),
    }
    for name, entry in stated.items():
        if name not in limits.joint_names:
            raise JointNotFound("joint", name, limits.joint_names)
        place = limits.joint_names.index(name)
        for flag, keys in columns.items():
            for key, array in keys:
                if entry.get(flag, key in entry) and key in entry:
                    array[place] = float(entry[key])
    (_, velocity), (_, acceleration) = (
        columns["has_velocity_limits"][0],
        columns["has_acceleration_limits"][0],
    )
    defaulted = _default(units, limits.joint_names, velocity, acceleration, mimics=mimics)
    (_, lower), (_, upper) = columns["has_position_limits"]
    for name, low, high in zip(limits.joint_names, lower, upper, strict=True):
        if low > high:
            reason = f"its position limits {low:g} and {high:g} leave it no position"
            raise ModelError(f"joint {shown(name)}: {reason}")
    return JointLimits(
        limits.joint_names,
        readonly(lower),
        readonly(upper),
        readonly(velocity),
        readonly(acceleration),
        readonly(columns["has_jerk_limits"][0][1]),
        readonly(columns["has_effort_limits"][0][1]),
        tuple(defaulted),
    )


def not_stated(name: str, kind: LimitKind, limit: float, unit: str) -> str:
    """Print a chosen limit: "elbow acceleration 229.2 deg/s^2 (no limit stated)"."""
    return f"{name} {kind.value} {in_unit(limit, unit + PER_SECOND[kind])} (no limit stated)"


def _default(
    units: Mapping[str, str],
    names: tuple[str, ...],
    velocity: Floats,
    acceleration: Floats,
    *,
    mimics: Collection[str],
) -> list[str]:
    said: list[str] = []
    for place, name in enumerate(names):
        if name in mimics:
            for array in (velocity, acceleration):
                array[place] = array[place] if array[place] > 0.0 else np.inf
            continue
        if not (np.isfinite(velocity[place]) and velocity[place] > 0.0):
            velocity[place] = DEFAULT_VELOCITY
            said.append(not_stated(name, LimitKind.VELOCITY, float(velocity[place]), units[name]))
        if not (np.isfinite(acceleration[place]) and acceleration[place] > 0.0):
            acceleration[place] = velocity[place] / DEFAULT_ACCELERATION_TIME
            said.append(not_stated(name, LimitKind.ACCELERATION, float(acceleration[place]), units[name]))
    return said


def read_joint_limits(path: Path) -> Mapping[str, Mapping[str, Any]]:
    """Read the `joint_limits` mapping of MoveIt's `joint_limits.yaml`."""
    limits = read_document(path)["joint_limits"]
    if limits.missing:
        raise limits.error("is missing")
    return {name: _checked(joint) for name, joint in limits.members().items()}


def _checked(joint: Node) -> Mapping[str, float | bool]:
    if joint.missing:
        raise joint.error("must be a mapping, is missing")
    found: dict[str, float | bool] = {}
    for key, node in joint.members().items():
        if key in _COLUMNS:
            if not isinstance(node.value, bool):
                raise node.error(f"must be true or false, is {shown(node.value)}")
            found[key] = node.value
        elif key in _LIMITS:
            number = node.number()
            if abs(number) >= _LARGEST:
                raise node.error(f"is too large: {number:g}")
            if key not in _COLUMNS["has_position_limits"] and number < 0.0:
                raise node.error(f"must not be negative, is {number:g}")
            found[key] = number
        elif key not in _OTHERS and (near := get_close_matches(key, (*_COLUMNS, *_LIMITS), 1, 0.8)):
            raise joint.error(f"unknown key {shown(key)}; did you mean {shown(near[0])}?")
    lower, upper = found.get("min_position", -_LARGEST), found.get("max_position", _LARGEST)
    if found.get("has_position_limits", True) and lower > upper:
        raise joint.error(f"min_position {lower:g} is above max_position {upper:g}")
    return found
