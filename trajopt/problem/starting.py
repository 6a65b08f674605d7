"""Velocities and accelerations of joints at the start."""

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from trajopt.robot.joints import joint_unit
from trajopt.robot.limits import JointLimits, LimitKind
from trajopt.values.arrays import Floats, number, readonly
from trajopt.values.errors import JointNotFound, ProblemError
from trajopt.values.likely_units import meant_at_speed
from trajopt.values.printed import in_unit

KINDS = (LimitKind.VELOCITY, LimitKind.ACCELERATION)
"""Limits on start rates, in the order of derivatives."""


def start_rates(
    stated: Mapping[str, float], kind: LimitKind, limits: JointLimits, model: pin.Model
) -> Floats:
    """Return the velocities or accelerations at the start, shape (n,); zero for unnamed joints.

    Args:
        stated: Joint -> velocity [rad/s | m/s] or acceleration [rad/s^2 | m/s^2].
        kind: Velocity or acceleration.
        limits: Limits of the group's n joints.
        model: Pinocchio's model of the robot.

    Raises:
        JointNotFound: If a joint is not in the group.
        ShapeError: If a value is not a number.
        ProblemError: If a value exceeds its limit.
    """
    names, rates = limits.joint_names, np.zeros(len(limits.joint_names))
    most = limits.velocity if kind is LimitKind.VELOCITY else limits.acceleration
    for joint, value in stated.items():
        if joint not in names:
            raise JointNotFound("joint of the group", joint, names)
        place = names.index(joint)
        unit = joint_unit(model, joint, order=1 + KINDS.index(kind))
        rates[place] = number(f"start {kind.value} of {joint}", value)
        if abs(rates[place]) > most[place]:
            here, limit = (in_unit(float(rate), unit) for rate in (rates[place], most[place]))
            words = f"{joint} cannot start at {here}: its {kind.value} limit is {limit}"
            meant = meant_at_speed(abs(float(rates[place])), float(most[place]), unit)
            raise ProblemError(words + limits.because(joint, kind) + meant)
    return readonly(rates)


def in_motion(model: pin.Model, velocity: Mapping[str, float], acceleration: Mapping[str, float]) -> str:
    """Format joint rates at the start: "elbow at 22.9 deg/s"; empty if all are zero."""
    return ", ".join(
        f"{joint} at {in_unit(value, joint_unit(model, joint, order=order))}"
        for order, stated in enumerate((velocity, acceleration), start=1)
        for joint, value in stated.items()
    )
