"""Robot state messages: joint positions and attached objects."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import cast

import numpy as np

from trajopt.files.messages import JointState, MotionPlanRequest, RobotState, document_of
from trajopt.files.moveit.motion_plan_request import request_of
from trajopt.files.moveit.scene_messages import checked_joint_positions, layered_positions
from trajopt.problem.problem import Problem
from trajopt.robot.joints import drawing_range
from trajopt.robot.loading.groups import Group
from trajopt.robot.loading.mimics import followed_limits
from trajopt.robot.loading.pinocchio_model import joint_above, joint_frame_names
from trajopt.robot.robot import Robot
from trajopt.ros.commander.world import World
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats


def within_bounds(message: object, robot: Robot) -> RobotState:
    """Clip a state's joints to their limits; wrap continuous joints to [-pi, pi]."""
    named = checked_joint_positions(document_of(message, "robot state"), robot)
    index = robot.index(named)
    lower, upper = robot.limits.lower[index], robot.limits.upper[index]
    values = np.array(list(named.values()))
    turned = np.remainder(values + np.pi, 2.0 * np.pi) - np.pi
    values = np.where(np.isinf(lower) & np.isinf(upper), turned, np.clip(values, lower, upper))
    return RobotState(joint_state=JointState(name=list(named), position=values.tolist()))


def joint_names(robot: Robot, group: Group | None = None) -> list[str]:
    named = list(joint_frame_names(robot.model))
    if group is None:
        return named
    above = {joint_above(robot.model, link) for link in _moved(group)}
    return [name for name in named if name in above or name in group.joints]


def variable_names(robot: Robot, group: Group) -> list[str]:
    """Return MoveIt's variables of a group: its planned joints, and those of it that mimic them."""
    chosen = {*group.joints, *(joint for joint in joint_names(robot, group) if joint in robot.mimics)}
    return [joint for joint in robot.joint_names if joint in chosen]


def random_positions(robot: Robot, joints: Sequence[str], rng: np.random.Generator) -> dict[str, float]:
    """Draw positions within the limits of joints and of those that mimic them; [-pi, pi] if without end."""
    limits = followed_limits(robot.limits, tuple(joints), robot.mimics)
    lower, upper = drawing_range(limits)
    drawn = lower + rng.random(len(joints)) * (upper - lower)
    return dict(zip(joints, drawn.tolist(), strict=True))


def link_names(robot: Robot, group: Group | None = None) -> list[str]:
    if group is None:
        return list(robot.links)
    below = {link: joint_above(robot.model, link) for link in robot.links}
    return [link for link in robot.links if link in _moved(group) or below[link] in group.joints]


def _moved(group: Group) -> tuple[str, ...]:
    return group.links if group.tip is None else group.links[1:]


def state_positions(state: object, world: World) -> Floats:
    """Return positions of all joints in a state or by name, by default the current ones [rad | m]."""
    robot = world.robot
    now = world.named_positions
    if state is None:
        return layered_positions(robot, now)
    if isinstance(state, Mapping):
        return layered_positions(robot, now, cast("Mapping[str, float]", state))
    return layered_positions(robot, now, checked_joint_positions(document_of(state, "robot state"), robot))


def problem_of(request: MotionPlanRequest, scene: Scene, positions: Floats) -> Problem:
    """Convert a motion plan request to a problem; missing joints have the current positions [rad | m]."""
    now = dict(zip(scene.robot.joint_names, positions.tolist(), strict=True))
    read = request_of(document_of(request, "motion plan request"), scene, now)
    return replace(read.problem(), name=request.group_name)
