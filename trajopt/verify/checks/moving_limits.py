"""The limits that are judged: of the group's joints, and of each joint that mimics one of them."""

import numpy as np

from trajopt.robot.limits import JointLimits
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import readonly
from trajopt.values.errors import ProblemError, shown


def moving_limits(reduced: ReducedModel, limits: JointLimits | None) -> JointLimits:
    """Return limits of all joints that move, in the model's order.

    Those of mimic joints are the robot's as they are stated, not what follows from them for the joints
    that they follow.

    Args:
        reduced: The model.
        limits: Of the group's joints, or of all that move; the robot's where None or not named.

    Raises:
        ProblemError: If they are of other joints.
    """
    moving = reduced.moving_joints
    if limits is not None and limits.joint_names == moving:
        return limits
    stated = reduced.derived_of_robot(_stated)
    if limits is None:
        return stated
    if limits.joint_names != reduced.joint_names:
        raise ProblemError(
            f"the limits are of {', '.join(limits.joint_names)}, but group {shown(reduced.group)} has the "
            f"joints {', '.join(reduced.joint_names)}"
        )
    places = np.array([moving.index(joint) for joint in reduced.joint_names], dtype=np.int64)
    columns = [
        np.array(column)
        for column in (
            stated.lower, stated.upper, stated.velocity, stated.acceleration, stated.jerk, stated.effort,
        )
    ]  # fmt: skip
    given = (limits.lower, limits.upper, limits.velocity, limits.acceleration, limits.jerk, limits.effort)
    for column, values in zip(columns, given, strict=True):
        column[places] = values
    return JointLimits(moving, *(readonly(column) for column in columns), defaulted=limits.defaulted)


def _stated(reduced: ReducedModel) -> JointLimits:
    robot = reduced.scene.robot
    return robot.limits.take(robot.index(reduced.moving_joints))


def group_part(reduced: ReducedModel, limits: JointLimits) -> JointLimits:
    """Return those of the group's joints, of limits of all joints that move."""
    moving = reduced.moving_joints
    if moving == reduced.joint_names:
        return limits
    return limits.take(np.array([moving.index(joint) for joint in reduced.joint_names], dtype=np.int64))


def joint_words(reduced: ReducedModel, joint: str) -> str:
    """Return a joint's name, and of a mimic joint which one it follows."""
    mimic = reduced.scene.robot.mimics.get(joint)
    return joint if mimic is None else f"{joint}, which follows {mimic.source},"
