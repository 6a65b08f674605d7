"""Configurations in the forms that callers use, resolved to positions of all joints."""

from collections.abc import Mapping
from typing import Protocol, TypeAlias, cast, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from trajopt.robot.joints import joint_unit
from trajopt.robot.robot import Robot
from trajopt.values.arrays import Floats, floats, is_array_like, one_of
from trajopt.values.errors import ProblemError, ShapeError, listed, shown


@runtime_checkable
class HasFinalState(Protocol):
    """Anything that ends in a configuration: a plan, a result, a pick and place."""

    @property
    def final_state(self) -> Mapping[str, float]:
        """Joint -> position of all joints at the end [rad | m]."""
        ...


ConfigurationLike: TypeAlias = str | Mapping[str, float] | ArrayLike | HasFinalState
"""Name of a state, joint -> position [rad | m], positions of the group's joints or of all joints, or a
motion, of which the end is taken.
"""

FORMS = (
    "the name of a state, joint -> position, positions of the group's joints or of all joints, "
    "or a plan, for its end"
)


def stated_configuration(
    robot: Robot,
    name: str,
    given: ConfigurationLike,
    *,
    group: str = "",
    degrees: bool = False,
    others: Floats | None = None,
) -> Floats:
    """Return the positions of all joints in a configuration, shape (number of joints,) [rad | m].

    Joints not named are at `others`, or at the position nearest to zero inside their limits. Numbers for all
    joints are in the order of `robot.joint_names`, others in that of `robot.group(group).joints`.

    Args:
        name: Of the argument, for errors.
        group: The group whose states are preferred and whose joints an array may be for. If empty, an array
            may be for any group, provided that all groups with that number of joints have the same joints.
        degrees: Whether positions of revolute joints by name or in an array are in degrees; states and
            ends of motions are always in radians.
    """
    in_degrees = one_of("degrees", degrees, bool)
    if isinstance(given, str):
        positions = _in_state(robot, group, given, others)
    elif isinstance(given, Mapping):
        positions = robot.positions(given, degrees=in_degrees, others=others)
    elif is_array_like(given):
        joints, numbers = _of_joints(robot, name, cast("ArrayLike", given), group)
        turns = np.array([joint_unit(robot.model, joint) == "rad" for joint in joints], dtype=bool)
        numbers = np.where(turns & in_degrees, np.deg2rad(numbers), numbers)
        if joints != robot.joint_names:
            return robot.positions(dict(zip(joints, map(float, numbers), strict=True)), others=others)
        positions = numbers
    elif isinstance(given, HasFinalState):
        positions = robot.positions(given.final_state)
    else:
        raise ProblemError(f"{name} must be {FORMS}, is {shown(given)}")
    return robot.followed(positions, checked=robot.mimics)


def joints_of(robot: Robot, group: str, count: int) -> tuple[str, ...]:
    """Return the joints that an array of this length is for; empty if that is ambiguous."""
    if count == len(robot.joint_names):
        return robot.joint_names
    groups = (robot.group(group),) if group else tuple(robot.groups.values())
    found = {each.joints for each in groups if len(each.joints) == count}
    return found.pop() if len(found) == 1 else ()


def _of_joints(robot: Robot, name: str, given: ArrayLike, group: str) -> tuple[tuple[str, ...], Floats]:
    numbers = floats(name, given, (None,))
    joints = joints_of(robot, group, len(numbers))
    if not joints:
        raise ShapeError(name, _missing(robot, group, len(numbers)))
    return joints, numbers


def _in_state(robot: Robot, group: str, name: str, others: Floats | None) -> Floats:
    elsewhere = {
        joint: at
        for (_, state), found in reversed(tuple(robot.states.items()))
        if state == name
        for joint, at in found.items()
    }
    own = robot.states.get((group, name), dict[str, float]())
    together = {joint: at for joint, at in {**elsewhere, **own}.items() if joint not in robot.mimics}
    return robot.positions(together if elsewhere else name, others=others)


def _missing(robot: Robot, group: str, count: int) -> str:
    joints = robot.joint_names
    own = f" group {group} has {len(robot.group(group).joints)} joints," if group else ""
    words = f"has {count} numbers,{own} and the robot has {len(joints)} joints"
    driven = tuple(joint for joint in joints if joint not in robot.mimics)
    if len(driven) == count:
        absent = [joint for joint in joints if joint not in driven]
        lack = " and ".join(absent) if len(absent) == 2 else listed(absent)
        are = "is" if len(absent) == 1 else "are"
        return (
            f"{words}: if they are those that follow no other, {lack} {are} missing; "
            "give all, or joint -> position"
        )
    return f"{words}: {listed(joints)}; give one for each, or joint -> position"


def initial_positions(robot: Robot) -> Floats:
    """Return the default positions (n,) [rad | m]: each group in its first named state."""
    chosen: dict[str, float] = {}
    for group in robot.groups:
        name = next((state for owner, state in robot.states if owner == group), None)
        if name is not None:
            chosen = {**robot.state(name, group=group), **chosen}
    return robot.positions(chosen)
