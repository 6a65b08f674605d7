"""Other limits than a description states: of torque, scaled or turned off; of jerk, where it states none."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from trajopt.robot.limits import JointLimits, LimitKind, not_stated
from trajopt.values.arrays import number, readonly, sequence
from trajopt.values.errors import JointNotFound, ShapeError, listed

DEFAULT_RISE = 0.1
"""The jerk limit that is chosen for a joint that states none lets its acceleration rise to its limit in this
time [s]: one period of a swing at 10 Hz. Arms swing at some 5 to 20 Hz, and an acceleration that rises over a
whole period of a swing leaves nothing of it behind."""


def torque_scaled(
    limits: JointLimits, scaling: float, joints: Iterable[str] | None
) -> tuple[JointLimits, str]:
    """Return limits with those of torque multiplied, and a sentence that says so.

    Args:
        limits: Of all joints.
        scaling: The factor; inf turns limits off.
        joints: The joints that it is for; all when None.

    Raises:
        ShapeError: If the factor is not positive.
        JointNotFound: If one is no movable joint.
    """
    factor = number("scaling", scaling, infinite=True)
    if factor <= 0.0:
        raise ShapeError("scaling", f"is a positive factor, or inf for no limit; is {factor:g}")
    names, whose = _named(limits, joints)
    said = "turned off" if factor == np.inf else f"multiplied by {factor:g}"
    effort = np.array(limits.effort)
    effort[[limits.joint_names.index(name) for name in names]] *= factor
    return replace(limits, effort=readonly(effort)), f"torque limits of {whose} are {said}"


def jerk_limited(
    limits: JointLimits, rise: float | None, joints: Iterable[str] | None, *, units: Mapping[str, str]
) -> tuple[JointLimits, str]:
    """Return limits with the jerk limited too, and a sentence that says so; none where nothing changes.

    Args:
        limits: Of all joints.
        rise: Time that an acceleration takes at least to reach its limit [s]. When None, `DEFAULT_RISE` for
            joints that have no limit of their jerk, and others keep theirs.
        joints: The joints that it is for; all when None. Joints without a limit of acceleration, which follow
            others, have none of jerk either.
        units: "rad" or "m" of each joint.

    Raises:
        ShapeError: If the time is not positive.
        JointNotFound: If one is no movable joint.
    """
    if rise is not None and number("rise", rise) <= 0.0:
        raise ShapeError("rise", f"is a positive time [s], is {rise:g}")
    names, _ = _named(limits, joints)
    jerk, chosen = np.array(limits.jerk), list(limits.defaulted)
    changed: list[str] = []
    for name in names:
        place = limits.joint_names.index(name)
        slow = float(limits.acceleration[place]) / (DEFAULT_RISE if rise is None else rise)
        stated = bool(np.isfinite(jerk[place]))
        if not np.isfinite(slow) or (stated and (rise is None or jerk[place] <= slow)):
            continue
        jerk[place] = slow
        changed.append(name)
        if not stated:
            chosen.append(not_stated(name, LimitKind.JERK, slow, units[name]))
    if not changed:
        return limits, ""
    how = f"the acceleration limit is reached in {DEFAULT_RISE if rise is None else rise:g} s"
    said = f"jerk limits of {listed(changed)} are chosen: {how}"
    return replace(limits, jerk=readonly(jerk), defaulted=tuple(chosen)), said


def _named(limits: JointLimits, joints: Iterable[str] | None) -> tuple[tuple[str, ...], str]:
    if joints is None:
        return limits.joint_names, "all joints"
    names = tuple(sequence("joints", joints))
    for name in names:
        if name not in limits.joint_names:
            raise JointNotFound("joint", name, limits.joint_names)
    return names, listed(names)
