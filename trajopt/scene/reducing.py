"""Builds reduced models: fixes all joints of a robot but those of a group, in a scene.

All other joints keep their start positions, even outside their limits. Data that depends only on the robot,
or only on one object, is computed once and shared by all scenes with it.
"""

import copyreg
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from trajopt.robot.loading.groups import Group
from trajopt.robot.loading.pinocchio_model import ModelData, model_data, model_of
from trajopt.robot.robot import Robot
from trajopt.scene.pairs import collision_model_of
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reduced_robot import reduce_robot
from trajopt.scene.scene import Scene
from trajopt.scene.timed import timed_model
from trajopt.values.arrays import Floats
from trajopt.values.errors import ModelError, shown
from trajopt.values.errors.arguments import checked


def _pickled(reduced: ReducedModel) -> tuple[Callable[..., ReducedModel], tuple[Any, ...]]:
    """Pickle a model by its scene; a model with a load is pickled whole."""
    robot = reduce_robot(reduced.scene.robot, reduced.group, reduced.start)
    loaded = None if reduced.model is robot.model else model_data(reduced.model)
    return _again, (reduced.scene, reduced.group, reduced.start, loaded)


def _again(scene: Scene, group: str, start: Floats, loaded: ModelData | None) -> ReducedModel:
    reduced = reduce_model(scene, group, start)
    return reduced if loaded is None else replace(reduced, model=model_of(loaded))


copyreg.pickle(ReducedModel, _pickled)


@checked
def reduce_model(scene: Scene, group: str, start: Floats) -> ReducedModel:
    """Fix every joint outside the group at its start position; mimic joints follow.

    Args:
        scene: The scene.
        group: Name of the planning group.
        start: Positions of all joints, shape (number of joints,) [rad | m].

    Raises:
        GroupNotFound: If the robot has no such group.
        MimicOutOfRange: If no position of a joint keeps one that follows it within its limits.
    """
    start = scene.robot.followed(start)
    robot = reduce_robot(scene.robot, group, start)
    collision_model = collision_model_of(scene, robot)
    return ReducedModel(
        scene,
        group,
        start,
        robot.model,
        robot.joint_names,
        robot.limits,
        robot.mimic_matrix,
        robot.mimic_offset,
        collision_model,
        timed_model,
    )


def tool_frame(reduced: ReducedModel) -> str:
    """Return the name of the frame that represents the group's motion.

    Tip link and hand move together, so this is a tool frame on the same joint if there is one: the last of
    the scene, else the first of the robot; else the link there whose origin is farthest from the joint. A
    group without a tip link ends at the body of its last joint.
    """
    tip = reduced.scene.robot.group(reduced.group).tip
    last = reduced.model.getJointId(reduced.joint_names[-1])
    return _tool_on(reduced, last if tip is None else reduced.attachment(tip)[0])


def tool_frames(reduced: ReducedModel) -> tuple[str, ...]:
    """Return one frame for each tool that a group moves: `tool_frame`, or one at the end of each branch.

    A group without a tip link may move several arms; each ends at its last joint.
    """
    if reduced.scene.robot.group(reduced.group).tip is not None:
        return (tool_frame(reduced),)
    joints = [reduced.model.getJointId(name) for name in reduced.joint_names]
    before: set[int] = set()
    for joint in joints:
        parent = int(reduced.model.parents[joint])
        while parent:
            before.add(parent)
            parent = int(reduced.model.parents[parent])
    return tuple(_tool_on(reduced, joint) for joint in joints if joint not in before)


def _tool_on(reduced: ReducedModel, carrier: int) -> str:
    """Return the tool frame, or else the farthest link, on a joint."""
    robot = reduced.scene.robot
    tip = robot.group(reduced.group).tip
    for name in (*reversed(tuple(reduced.scene.tools)), *robot.frames):
        if reduced.attachment(name)[0] == carrier:
            return name
    reach: dict[str, float] = {}
    for name in (*((tip,) if tip is not None else ()), *robot.links):
        joint, where = reduced.attachment(name)
        if joint == carrier:
            # Of equals the first stays: the tip link.
            reach.setdefault(name, round(float(np.linalg.norm(where.translation)), 9))
    return max(reach, key=lambda name: reach[name])


def tool_point(reduced: ReducedModel, frame: str, positions: Floats) -> Floats:
    """Return the origin of a frame for the group's positions (n,), shape (3,) in the world [m]."""
    return reduced.scene.placement_of(frame, reduced.all_positions(positions)).translation


WHOLE = "all that is simulated"
"""Name of the temporary group."""


def driven_joints(robot: Robot) -> tuple[str, ...]:
    """Return the joints with motors: all that do not mimic another."""
    return tuple(name for name in robot.joint_names if name not in robot.mimics)


def whole_robot(scene: Scene, joints: tuple[str, ...], start: Floats) -> ReducedModel:
    """Return the reduced model of any joints of a robot.

    Args:
        scene: Robot and scene.
        joints: Free joints.
        start: Positions of all joints [rad | m].

    Raises:
        ModelError: If the robot has a group with the name of the temporary one.
    """
    robot = scene.robot
    if WHOLE in robot.groups:
        raise ModelError(f"robot {shown(robot.name)} has a group {shown(WHOLE)}, a reserved name; rename it")
    group = Group(WHOLE, joints, robot.links, None)
    wider = replace(robot, groups={**robot.groups, WHOLE: group})
    return reduce_model(replace(scene, robot=wider), WHOLE, start)
