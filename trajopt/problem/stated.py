"""Conversion of starts, goals, waypoints and knots from any accepted form to values of a group."""

from collections.abc import Mapping, Sequence
from typing import cast

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from trajopt.problem.requirements import (
    AxisAlignment,
    DistanceBetween,
    FollowsCurve,
    FramePlacement,
    Gaze,
    GoalSet,
    JointPositions,
    LineOfSight,
    PointOnArc,
    PositionInRegion,
    Requirement,
    frame_placement,
    joint_positions,
)
from trajopt.problem.requirements.alternatives import GoalLike
from trajopt.robot.configuration import FORMS, HasFinalState, joints_of, stated_configuration
from trajopt.robot.joints import JointLimits, LimitKind, joint_unit
from trajopt.robot.loading.pinocchio_model import link_joint
from trajopt.robot.robot import Robot
from trajopt.scene.group_tools import tool_of
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, floats, mapping, number, one_of, readonly, sequence
from trajopt.values.errors import (
    JointNotFound,
    ModelError,
    ProblemError,
    ShapeError,
    StateNotFound,
    listed,
    shown,
)
from trajopt.values.likely_units import meant_at_speed, stated_angle
from trajopt.values.placement import WORLD, Placement, as_placement
from trajopt.values.printed import in_unit


def stated_rates(
    robot: Robot, name: str, rates: Mapping[str, float], *, degrees: bool
) -> Mapping[str, float]:
    """Return velocities or accelerations by joint, converted from degrees for revolute joints."""
    given = mapping(name, rates)
    if not one_of("degrees", degrees, bool):
        return given
    turning = {joint for joint in robot.joint_names if joint_unit(robot.model, joint) == "rad"}
    return {
        joint: stated_angle(f"{name} of {joint}", rate, degrees=joint in turning)
        for joint, rate in given.items()
    }


def only_group(robot: Robot) -> str:
    """Return the robot's only group."""
    if len(robot.groups) != 1:
        raise ProblemError(f"group: choose one of {listed(tuple(robot.groups))}")
    return next(iter(robot.groups))


def stated_goal(
    scene: Scene, group: str, goal: GoalLike | Sequence[GoalLike] | GoalSet, *, degrees: bool
) -> tuple[Requirement, ...] | dict[str, tuple[Requirement, ...]]:
    """Return the requirements at the end, or a goal set with the requirements of each goal.

    Args:
        goal: One requirement or several, or any one goal of a set.
        degrees: Whether joint positions by name are in degrees.
    """
    if isinstance(goal, GoalSet):
        each = goal.alternatives.items()
        return {
            name: _required(scene, group, f"goal {shown(name)}", of, degrees=degrees) for name, of in each
        }
    return _required(scene, group, "goal", goal, degrees=degrees)


def stated_waypoints(
    scene: Scene,
    group: str,
    waypoints: Sequence[GoalLike | Sequence[GoalLike]] | Mapping[str, GoalLike | Sequence[GoalLike]],
    *,
    degrees: bool,
) -> dict[str, tuple[Requirement, ...]]:
    """Return the requirements at each waypoint, by name or number from 1; see `stated_goal`."""
    named = waypoints
    if not isinstance(named, Mapping):
        named = {str(number): item for number, item in enumerate(sequence("waypoints", named), start=1)}
    return {
        name: _required(scene, group, f"waypoint {shown(name)}", item, degrees=degrees)
        for name, item in named.items()
    }


def _required(
    scene: Scene, group: str, name: str, wanted: GoalLike | Sequence[GoalLike], *, degrees: bool
) -> tuple[Requirement, ...]:
    items = cast("Sequence[GoalLike]", wanted) if isinstance(wanted, list | tuple) else ()
    if wanted is not items or not (len(items) == 0 or any(map(_is_one, items))):
        items = (cast("GoalLike", wanted),)  # a placement in one of its forms is a list or a tuple too
    return tuple(_requirement(scene, group, name, item, degrees=degrees) for item in items)


def _is_one(item: object) -> bool:
    matrix = hasattr(item, "__array__") and _is_matrix(item)
    return matrix or isinstance(item, Requirement | str | Mapping | Placement | pin.SE3 | HasFinalState)


def _requirement(scene: Scene, group: str, name: str, item: GoalLike, *, degrees: bool) -> Requirement:
    if isinstance(item, Requirement):
        return item
    if isinstance(item, str):
        return joint_positions(_state(scene.robot, group, item))
    if isinstance(item, Mapping):
        if not item:
            raise ProblemError(f"{name}: name at least one joint")
        return joint_positions(_in_radians(scene.robot, name, item, degrees=degrees))
    if isinstance(item, HasFinalState):
        return joint_positions(_of_group(scene.robot, group, stated_configuration(scene.robot, name, item)))
    if numbers := _of_numbers(scene.robot, group, name, item, degrees=degrees):
        return joint_positions(numbers)
    try:
        where = as_placement(name, item)
    except ModelError as error:
        if _is_matrix(item):
            raise
        forms = f"a requirement or several, {FORMS}, or a placement"
        raise ProblemError(f"{name} must be {forms}, is {shown(item)}{_hint(item)}") from error
    return frame_placement(tool_of(scene, group), where)


def _is_matrix(item: object) -> bool:
    try:
        return np.shape(cast("ArrayLike", item)) == (4, 4)
    except ValueError:  # rows of different lengths
        return False


def _of_numbers(
    robot: Robot, group: str, name: str, item: object, *, degrees: bool
) -> Mapping[str, float] | None:
    try:
        count = len(floats(name, cast("ArrayLike", item), (None,)))
    except ShapeError:
        return None
    if not joints_of(robot, group, count):
        return None
    at = stated_configuration(robot, name, cast("ArrayLike", item), group=group, degrees=degrees)
    return _of_group(robot, group, at)


def _of_group(robot: Robot, group: str, positions: Floats) -> dict[str, float]:
    joints = robot.group(group).joints
    return dict(zip(joints, map(float, positions[robot.index(joints)]), strict=True))


def _hint(item: object) -> str:
    try:
        count = len(floats("goal", cast("ArrayLike", item), (None,)))
    except ShapeError:
        return ""
    return " (a position alone; placement((x, y, z)) has the identity orientation)" if count == 3 else ""


def _in_radians(
    robot: Robot, name: str, positions: Mapping[str, float], *, degrees: bool
) -> dict[str, float]:
    _ = robot.index(mapping(name, positions))
    return {
        joint: stated_angle(
            f"position of {joint}",
            value,
            degrees=one_of("degrees", degrees, bool) and joint_unit(robot.model, joint) == "rad",
        )
        for joint, value in positions.items()
    }


def _state(robot: Robot, group: str, name: str) -> Mapping[str, float]:
    joints = robot.group(group).joints
    if (group, name) in robot.states:
        found = robot.state(name, group=group)
        return {joint: found[joint] for joint in joints if joint in found}
    for owner, state in robot.states:
        found = robot.states[owner, state]
        if state == name and set(joints) <= found.keys():
            return {joint: found[joint] for joint in joints}
    known = {
        state
        for owner, state in robot.states
        if owner == group or set(joints) <= robot.states[owner, state].keys()
    }
    raise StateNotFound(f"state of group {shown(group)}", name, known, left_out=robot.left_out.get(name, ""))


def check_waypoints(waypoints: Mapping[str, Sequence[object]], knots: int) -> None:
    for name, wanted in waypoints.items():
        if not wanted or not all(isinstance(item, Requirement) for item in wanted):
            raise ProblemError(
                f"waypoint {shown(name)} is neither a requirement nor several: {shown(wanted)}"
            )
    least = len(waypoints) + 2
    if knots < least:
        raise ProblemError(f"{len(waypoints)} waypoints need at least {least} knots, not {knots}")


def stated_dwell(dwell: float) -> float:
    if number("dwell", dwell) < 0.0:
        raise ProblemError(f"dwell must not be negative, is {dwell:g} s")
    return float(dwell)


def check_goal(scene: Scene, item: Requirement, *, in_motion: bool) -> None:
    """Check the frames and joints of a goal, which may be a placement relative to a dynamic obstacle.

    Args:
        in_motion: Whether the start has a velocity or an acceleration.
    """
    moving = _moving(scene, item)
    if not moving:
        check_names(scene, item)
        return
    if not isinstance(item, FramePlacement):
        raise ProblemError(
            f"{moving}: a goal on a dynamic obstacle must be a frame_placement(...), not {item}"
        )
    if in_motion:
        raise ProblemError(f"{moving}: a moving goal requires a start at rest")


RELATIVE = (
    AxisAlignment,
    DistanceBetween,
    FollowsCurve,
    FramePlacement,
    Gaze,
    PointOnArc,
    PositionInRegion,
)
"""Requirements that only a motion of their frames relative to each other changes."""


def check_names(scene: Scene, item: Requirement) -> None:
    """Check the frames and joints of a requirement."""
    scene.robot.index(item.joints)
    if moving := _moving(scene, item):
        raise ProblemError(f"{moving}: only goals may refer to frames of dynamic obstacles")
    if isinstance(item, RELATIVE):
        first, second = item.frames
        # A task picks up what stands there now.
        held = any(name != WORLD and scene.owner(name) in scene.objects for name in item.frames)
        if first == second or (not held and _joint(scene, first) == _joint(scene, second)):
            raise ProblemError(f"no motion changes it: {item} ({first} is fixed to {second})")
    if isinstance(item, LineOfSight):
        item.obstacles(scene)
    if isinstance(item, JointPositions) and item.in_degrees:
        for joint in item.joints:
            if joint_unit(scene.robot.model, joint) == "m":
                raise ProblemError(
                    f"position of {joint} is in degrees, but the joint is prismatic: give it in metres, "
                    "in joint_positions(...) of its own"
                )


def _joint(scene: Scene, frame: str) -> int:
    link = scene.holder(frame).link
    return 0 if link == WORLD else link_joint(scene.robot.model, link)


def _moving(scene: Scene, item: Requirement) -> str:
    for frame in item.frames:
        scene.holder(frame)
        carrier = scene.carrier(frame)
        if carrier is not None:
            moves = "moves by itself" if carrier == frame else f"is carried by {shown(carrier)}, which moves"
            return f"{shown(frame)} {moves}"
    return ""


DEFAULT_KNOTS = 24
"""Knots of a path; 20 to 32 perform alike, 16 lose a few problems."""

ROLLING_KNOTS = 48
"""Knots for bases with driven wheels. Their drift falls with the square of a step; with 24 knots it is 10 to
30 mm over ten metres.
"""

LEG_KNOTS = 8
"""Knots of the leg between two waypoints: enough for a detour around an obstacle."""

MOST_KNOTS = 2000
"""Time and memory grow with the square of the knots; this number takes some seconds and 0.3 GB."""


def stated_knots(robot: Robot, group: str, stated: int, waypoints: int = 0) -> int:
    """Return the number of knots of a group's path: the stated number, or the default if it is 0."""
    if stated != 0:
        whole = isinstance(stated, int)  # pyright: ignore[reportUnnecessaryIsInstance]
        if not whole or not 3 <= stated <= MOST_KNOTS:
            raise ProblemError(f"knots must be a whole number from 3 to {MOST_KNOTS}, not {shown(stated)}")
        return stated
    rolls = robot.base.rolling(robot.group(group).joints)
    least = DEFAULT_KNOTS if rolls is None else ROLLING_KNOTS
    return min(max(least, LEG_KNOTS * (waypoints + 1) + 1), MOST_KNOTS)


KINDS = (LimitKind.VELOCITY, LimitKind.ACCELERATION)
"""Limits on start rates, in the order of derivatives."""


def start_rates(
    stated: Mapping[str, float], kind: LimitKind, limits: JointLimits, model: pin.Model
) -> Floats:
    """Return the velocities or accelerations at the start, shape (n,); zero for unnamed joints.

    Args:
        stated: Joint -> velocity [rad/s | m/s] or acceleration [rad/s^2 | m/s^2].
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
