"""The robot's own part of a reduced model: the same for all scenes and starts with the same joints fixed."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from trajopt.robot.bodies import WORLD_ANCHOR, Anchor, FixedBody
from trajopt.robot.limits import JointLimits
from trajopt.robot.loading.mimic_limits import followed_limits
from trajopt.robot.loading.pinocchio_model import distinct_links, named_again
from trajopt.robot.robot import Robot
from trajopt.scene.driven_joints import DrivenJoints
from trajopt.values.arrays import Floats, readonly
from trajopt.values.cached import LruCache, cached_per_value
from trajopt.values.placement import WORLD, Placement


@dataclass(frozen=True, eq=False)
class ReducedRobot:
    """A robot with only one group's joints free.

    Attributes:
        model: Pinocchio's model of the free joints and of those that mimic them; never changed.
        joint_names: The group's joints, n of them.
        limits: Their limits, those of the joints that mimic them kept as well.
        mimic_matrix: Matrix (model joints, n) that maps the group's positions to the model's.
        mimic_offset: Offsets of mimicking joints, shape (model joints,).
        anchors: Where links and tool frames are, by name, with the world.
        bodies: Collision bodies of all links.
        driven: Joints that time drives, which carry what moves by itself; None where time stands still: then
            what changes with time is left out.
    """

    model: pin.Model
    joint_names: tuple[str, ...]
    limits: JointLimits
    mimic_matrix: Floats
    mimic_offset: Floats
    anchors: Mapping[str, Anchor]
    bodies: tuple[FixedBody, ...]
    driven: DrivenJoints | None = None


def reduce_robot(robot: Robot, group: str, start: Floats) -> ReducedRobot:
    """Fix every joint outside the group where it is at the start.

    The last answers are kept for each robot: they depend only on the joints that are fixed.

    Args:
        robot: The robot.
        group: Name of the planning group.
        start: Positions of all joints, shape (number of joints,) [rad | m].

    Raises:
        GroupNotFound: If the robot has no such group.
        MimicOutOfRange: If no position of a joint keeps one that follows it within its limits.
    """
    joints = robot.group(group).joints
    free = {*joints, *(name for name, mimic in robot.mimics.items() if mimic.source in joints)}
    locked = [place for place, name in enumerate(robot.joint_names) if name not in free]
    key = (group, tuple(start[locked].tolist()))
    return _reductions(robot).get(key, lambda: _reduced(robot, joints, locked, start))


@cached_per_value
def _reductions(robot: Robot) -> LruCache[tuple[str, tuple[float, ...]], ReducedRobot]:
    del robot
    return LruCache(8)


def _reduced(robot: Robot, joints: tuple[str, ...], locked: list[int], start: Floats) -> ReducedRobot:
    fixed = [place + 1 for place in locked]  # pinocchio counts the universe as joint 0
    whole = distinct_links(robot.model)  # Pinocchio looks frames up by name alone.
    model = named_again(pin.buildReducedModel(whole, fixed, robot.configuration(start)))
    names = tuple(model.names[1:])
    mimic_matrix, mimic_offset = np.zeros((len(names), len(joints))), np.zeros(len(names))
    for row, name in enumerate(names):
        if name in joints:
            mimic_matrix[row, joints.index(name)] = 1.0
        else:
            mimic = robot.mimics[name]
            mimic_matrix[row, joints.index(mimic.source)] = mimic.multiplier
            mimic_offset[row] = mimic.offset
    anchors = _anchors(model, robot)
    return ReducedRobot(
        model,
        joints,
        followed_limits(robot.limits, joints, robot.mimics),
        readonly(mimic_matrix),
        readonly(mimic_offset),
        anchors,
        tuple(
            FixedBody(body.name, body.owner, at.joint, at.placement * body.placement, body.shape)
            for body in robot.bodies
            for at in (anchors[body.frame],)
        ),
    )


def _anchors(model: pin.Model, robot: Robot) -> Mapping[str, Anchor]:
    anchors = {WORLD: WORLD_ANCHOR}
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY:
            where = frame.placement
            anchors[frame.name] = Anchor(
                int(frame.parentJoint),
                Placement(readonly(where.rotation.copy()), readonly(where.translation.copy())),
            )
    for name, frame in robot.frames.items():
        link = anchors[frame.link]
        anchors[name] = Anchor(link.joint, link.placement * frame.placement)
    return anchors
