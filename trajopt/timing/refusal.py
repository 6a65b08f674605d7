"""Diagnosis of paths that cannot be timed: the limit that holds at no speed."""

import numpy as np

from trajopt.native.timing import Kind, Outcome
from trajopt.native.timing import Retimed as Found
from trajopt.robot.joints import JointLimits, LimitKind
from trajopt.timing.result import RetimeFailure
from trajopt.values.arrays import Floats
from trajopt.values.trajectory import LONGEST

STILL = 1e-12
"""Largest joint travel of a path that counts as standing still [rad | m]."""
ROOM = 1e-3
"""Share of the longest duration that one joint's limit may need: bends and other joints slow the path
further.
"""


def immovable(knots: Floats, limits: JointLimits) -> RetimeFailure | None:
    """Find a joint that the path moves although one of its limits is zero."""
    moved = knots != knots[0]
    named = (("velocity", limits.velocity), ("acceleration", limits.acceleration), ("jerk", limits.jerk))
    for name, limit in named:
        stuck = np.nonzero(moved.any(axis=0) & (limit <= 0.0))[0]
        if len(stuck):
            joint = limits.joint_names[int(stuck[0])]
            lengths = np.linalg.norm(np.diff(knots, axis=0), axis=1)
            before = lengths[: int(moved[:, stuck[0]].argmax()) - 1]
            return RetimeFailure(
                f"the {name} limit of {joint} is {limit[stuck[0]]:g}, but the path moves it",
                joint,
                float(before.sum() / lengths.sum()),
            )
    return None


def endless(knots: Floats, limits: JointLimits) -> RetimeFailure | None:
    """Find a joint whose limits make the path longer than the longest trajectory."""
    span = np.ptp(knots, axis=0)
    named = (("velocity", limits.velocity), ("acceleration", limits.acceleration), ("jerk", limits.jerk))
    for order, (name, limit) in enumerate(named, start=1):
        allowed = np.where((span > STILL) & (limit > 0.0), limit, np.inf)
        seconds = span ** (1.0 / order) / allowed ** (1.0 / order)
        slowest = int(seconds.argmax())
        if seconds[slowest] > LONGEST * ROOM:
            joint = limits.joint_names[slowest]
            return RetimeFailure(
                f"the {name} limit of {joint} is {limit[slowest]:g}: the path would take more than "
                f"{seconds[slowest]:.2g} s, and {LONGEST * ROOM:.2g} s are the most",
                joint,
                0.0,
            )
    return None


def untimed(found: Found, limits: JointLimits) -> RetimeFailure | None:
    """Explain why the core found no timing; None if it found one."""
    match found.outcome:
        case Outcome.GRAVITY_TOO_STRONG:
            return _too_weak(found, limits)
        case Outcome.TOO_LONG:
            return RetimeFailure(
                f"within all limits together it would take {found.value:.2g} s; "
                f"{LONGEST * ROOM:.2g} s are the most",
                None,
                found.place,
            )
        case Outcome.NOTHING_FITS:
            return RetimeFailure("no speed along the path is within all limits", None, found.place)
        case Outcome.EXCEEDED:
            return _exceeded(found, limits)
        case Outcome.TIMED:
            return None


def _torque_joint(column: int, limits: JointLimits) -> int:
    """Convert an index among the joints with an effort limit to an index among all joints."""
    return int(np.nonzero(np.isfinite(limits.effort))[0][column])


def _too_weak(found: Found, limits: JointLimits) -> RetimeFailure:
    """Name the joint that cannot hold its weight.

    The arm could swing through such a point, but not stop there.
    """
    place = _torque_joint(found.column, limits)
    joint = limits.joint_names[place]
    return RetimeFailure(
        f"{joint} needs {found.value:.4g} only to hold still there, "
        f"its effort limit is {limits.effort[place]:.4g}",
        joint,
        found.place,
    )


def _exceeded(found: Found, limits: JointLimits) -> RetimeFailure:
    """Name the limit that a trajectory exceeds at any speed."""
    if found.kind is Kind.TOOL_SPEED:
        reason = "the speed limit of a tool is exceeded there at any speed"
        return RetimeFailure(reason, None, found.place)
    place = _torque_joint(found.column, limits) if found.kind is Kind.TORQUE else found.column
    joint = limits.joint_names[place]
    kinds = (
        (Kind.VELOCITY, LimitKind.VELOCITY),
        (Kind.ACCELERATION, LimitKind.ACCELERATION),
        (Kind.JERK, LimitKind.JERK),
    )
    limit = next((limit for kind, limit in kinds if kind is found.kind), None)
    mimic = "" if limit is None else limits.because(joint, limit)
    name = "effort" if limit is None else limit.value
    return RetimeFailure(
        f"the {name} limit of {joint}{mimic} is exceeded there at any speed", joint, found.place
    )
