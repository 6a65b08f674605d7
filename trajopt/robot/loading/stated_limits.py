"""Joint limits in files such as MoveIt's `joint_limits.yaml`, and defaults for missing ones."""

from collections.abc import Collection, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any, cast

import numpy as np

from trajopt.robot.joints import PER_SECOND, JointLimits, LimitKind
from trajopt.values.arrays import Floats, readonly
from trajopt.values.documents.files import number_of
from trajopt.values.errors import FileFormatError, JointNotFound, ModelError, shown
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
    from trajopt.values.documents.yaml_files import read_yaml

    documents = read_yaml(path)
    document = documents[0] if len(documents) == 1 else None
    entries = (
        cast("dict[object, object]", document).get("joint_limits") if isinstance(document, dict) else None
    )
    if not isinstance(entries, dict):
        raise FileFormatError(str(path), "has no mapping `joint_limits`")
    return {
        str(joint): _checked(str(path), f"joint_limits.{joint}", entry)
        for joint, entry in cast("dict[object, object]", entries).items()
    }


def _checked(path: str, place: str, entry: object) -> Mapping[str, float | bool]:
    if not isinstance(entry, dict):
        raise FileFormatError(path, f"{place}: must be a mapping, is {shown(entry)}")
    found: dict[str, float | bool] = {}
    for key, value in cast("dict[object, object]", entry).items():
        if key in _COLUMNS:
            if not isinstance(value, bool):
                raise FileFormatError(path, f"{place}.{key}: must be true or false, is {shown(value)}")
            found[str(key)] = value
        elif key in _LIMITS:
            number = number_of(value)
            if number is None or not abs(number) < _LARGEST:
                raise FileFormatError(path, f"{place}.{key}: must be a finite number, is {shown(value)}")
            if key not in _COLUMNS["has_position_limits"] and number < 0.0:
                raise FileFormatError(path, f"{place}.{key}: must not be negative, is {number:g}")
            found[str(key)] = number
        elif key not in _OTHERS and (near := get_close_matches(str(key), (*_COLUMNS, *_LIMITS), 1, 0.8)):
            raise FileFormatError(path, f"{place}: unknown key {shown(key)}; did you mean {shown(near[0])}?")
    lower, upper = found.get("min_position", -_LARGEST), found.get("max_position", _LARGEST)
    if found.get("has_position_limits", True) and lower > upper:
        raise FileFormatError(path, f"{place}: min_position {lower:g} is above max_position {upper:g}")
    return found
