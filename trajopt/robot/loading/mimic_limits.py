"""Limits of mimic joints, carried over to the joints that they follow.

Positions follow by factor and offset, derivatives by the factor alone. Efforts are not carried over: a mimic
joint has no motor, its torque is borne by the motor of the joint that it follows, and counted there.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from trajopt.robot.limits import JointLimits, LimitKind
from trajopt.robot.loading.urdf import Mimic
from trajopt.values.arrays import readonly
from trajopt.values.errors import MimicOutOfRange

ROUNDING = 1e-9
"""A mimic joint that never moves may stand this far beyond its range [rad | m]."""


def followed_limits(limits: JointLimits, joints: tuple[str, ...], mimics: Mapping[str, Mimic]) -> JointLimits:
    """Return limits of joints that also keep every joint that follows one of them within its own.

    Args:
        limits: Of all joints.
        joints: Those that are moved, n of them.
        mimics: Mimic joints by name, each with the joint that leads it.

    Raises:
        MimicOutOfRange: If no position of a joint keeps one that follows it within its limits.
    """
    places = np.array([limits.joint_names.index(joint) for joint in joints], dtype=np.int64)
    found = limits.take(places)
    for joint, mimic in mimics.items():
        if mimic.source in joints:
            found = _tightened(found, limits, joint, mimic)
    return found


def _tightened(found: JointLimits, limits: JointLimits, joint: str, mimic: Mimic) -> JointLimits:
    place, own = found.joint_names.index(mimic.source), limits.joint_names.index(joint)
    lower, upper = float(limits.lower[own]), float(limits.upper[own])
    if mimic.multiplier == 0.0:
        if not lower - ROUNDING <= mimic.offset <= upper + ROUNDING:
            why = f"always stands at {mimic.offset:g}, outside of its range [{lower:g}, {upper:g}]"
            raise MimicOutOfRange(joint, mimic.source, why)
        return found
    size = abs(mimic.multiplier)
    least, most = sorted((end - mimic.offset) / mimic.multiplier for end in (lower, upper))
    candidates = (
        (LimitKind.LOWER, found.lower, least),
        (LimitKind.UPPER, found.upper, most),
        (LimitKind.VELOCITY, found.velocity, float(limits.velocity[own]) / size),
        (LimitKind.ACCELERATION, found.acceleration, float(limits.acceleration[own]) / size),
        (LimitKind.JERK, found.jerk, float(limits.jerk[own]) / size),
    )
    changed = {kind.value: np.array(array) for kind, array, _ in candidates}
    binding = dict(found.binding)
    for kind, array, limit in candidates:
        if limit > array[place] if kind is LimitKind.LOWER else limit < array[place]:
            changed[kind.value][place] = limit
            binding[mimic.source, kind] = joint
    if least > found.upper[place] or most < found.lower[place]:
        why = (
            f"must stay in [{lower:g}, {upper:g}], but no position of {mimic.source} in "
            f"[{found.lower[place]:g}, {found.upper[place]:g}] has it there"
        )
        raise MimicOutOfRange(joint, mimic.source, why)
    return replace(
        found,
        lower=readonly(changed["lower"]),
        upper=readonly(changed["upper"]),
        velocity=readonly(changed["velocity"]),
        acceleration=readonly(changed["acceleration"]),
        jerk=readonly(changed["jerk"]),
        binding=binding,
    )
