"""Reduced models: a robot with a group's joints free, in a scene, alone or among dynamic obstacles."""

import copyreg
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np

from trajopt.robot.joints import JointLimits
from trajopt.robot.loading.groups import Group
from trajopt.robot.loading.pinocchio_model import ModelData, model_data, model_of
from trajopt.robot.robot import Robot
from trajopt.scene.pairs import collision_model_of
from trajopt.scene.reduced import ReducedModel, TimedModel
from trajopt.scene.reduced_robot import ReducedRobot, add_driven, reduce_robot
from trajopt.scene.scene import Scene
from trajopt.scene.track import Prediction, Timing
from trajopt.values.arrays import Bools, Floats, Ints, Printed, readonly
from trajopt.values.cached import LruCache, cached_in_value, cached_per_value
from trajopt.values.errors import ModelError, shown
from trajopt.values.errors.arguments import checked


def _pickled(reduced: ReducedModel) -> tuple[Callable[..., ReducedModel], tuple[Any, ...]]:
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

    A tool frame on the joint of the tip link if there is one: the last of the scene, else the first of the
    robot; else the link there whose origin is farthest from the joint. A group without a tip link ends at the
    body of its last joint.
    """
    tip = reduced.scene.robot.group(reduced.group).tip
    last = reduced.model.getJointId(reduced.joint_names[-1])
    return _tool_on(reduced, last if tip is None else reduced.attachment(tip)[0])


def tool_frames(reduced: ReducedModel) -> tuple[str, ...]:
    """Return one frame for each tool that a group moves: `tool_frame`, or one at the end of each branch."""
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


def timed_model(reduced: ReducedModel) -> TimedModel | None:
    """Return the timed model of a reduced one; None if its scene is static.

    The last results are cached for each scene.
    """
    scene = reduced.scene
    if not scene.changing:
        return None
    robot = reduce_robot(scene.robot, reduced.group, reduced.start)
    return _timed_models(scene).get(robot, lambda: _built(reduced, robot))


@cached_in_value
def _timed_models(scene: Scene) -> LruCache[ReducedRobot, TimedModel]:
    del scene  # the models refer to it
    return LruCache(4)


def _built(reduced: ReducedModel, robot: ReducedRobot) -> TimedModel:
    scene, model = reduced.scene, robot.model.copy()
    timings = {name: _timing(scene, name) for name in scene.changing}
    tracks = {
        name: motion.track for name in timings if (motion := scene.objects[name].timing.motion) is not None
    }
    drive = add_driven(model, tracks)
    extended = replace(
        robot,
        model=model,
        joint_names=(*robot.joint_names, *drive.joints.names),
        limits=_unlimited(robot.limits, drive.joints.names),
        mimic_matrix=_beside(robot.mimic_matrix, len(drive.joints.names)),
        mimic_offset=readonly(np.append(robot.mimic_offset, np.zeros(len(drive.joints.names)))),
        anchors={**robot.anchors, **drive.anchors},
        driven=drive.joints,
    )
    among = ReducedModel(
        scene,
        reduced.group,
        reduced.start,
        extended.model,
        extended.joint_names,
        extended.limits,
        extended.mimic_matrix,
        extended.mimic_offset,
        collision_model_of(scene, extended),
        _nothing_else,
    )
    return TimedModel(among, drive.joints, timings)


def _nothing_else(timed: ReducedModel) -> None:
    del timed


def _timing(scene: Scene, name: str) -> Timing:
    carrier = scene.carrier(name)
    motion: Prediction | None = None if carrier is None else scene.objects[carrier].timing.motion
    return replace(scene.objects[name].timing, motion=motion)


def _unlimited(limits: JointLimits, names: tuple[str, ...]) -> JointLimits:
    wide = np.full(len(names), np.inf)
    fields = ("upper", "velocity", "acceleration", "jerk", "effort")
    wider = {name: readonly(np.append(getattr(limits, name), wide)) for name in fields}
    lower = readonly(np.append(limits.lower, -wide))
    return replace(limits, joint_names=(*limits.joint_names, *names), lower=lower, **wider)


def _beside(matrix: Floats, count: int) -> Floats:
    """Extend a matrix by the identity for further joints."""
    rows, columns = matrix.shape
    whole = np.zeros((rows + count, columns + count))
    whole[:rows, :columns] = matrix
    whole[rows:, columns:] = np.eye(count)
    return readonly(whole)


@dataclass(frozen=True, eq=False)
class ChangingPairs(Printed):
    """The pairs with a dynamic obstacle; temporary contacts are left to the judge.

    Attributes:
        changes: Whether a body of the pair changes with time, shape (p,).
        required: Required clearance, shape (p,) [m].
        errors: Radius, velocity and acceleration of the error, shape (p, 3).
        appears: Time from which both exist, shape (p,) [s].
        expires: Time until which both exist, shape (p,) [s].
    """

    changes: Bools
    required: Floats
    errors: Floats
    appears: Floats
    expires: Floats

    @staticmethod
    def of(timed: TimedModel) -> "ChangingPairs":
        """Return the pairs of a timed model; computed once for each."""
        return _of(timed)

    def error_at(self, time: Floats | float, pair: Ints | slice) -> Floats:
        """Return the error of pairs at times [m]."""
        radius, velocity, acceleration = self.errors[pair].T
        return radius + velocity * time + acceleration * np.square(time) / 2.0


@cached_per_value
def _of(timed: TimedModel) -> ChangingPairs:
    pairs, bodies = timed.reduced.pairs, timed.reduced.bodies
    count = len(pairs.first)
    changes, errors = np.zeros(count, dtype=np.bool_), np.zeros((count, 3))
    appears, expires = np.full(count, -inf), np.full(count, inf)
    for pair, both in enumerate(zip(pairs.first.tolist(), pairs.second.tolist(), strict=True)):
        for body in both:
            timing = timed.timings.get(bodies[int(body)].owner)
            if timing is not None:
                changes[pair] = True
                errors[pair] += (0.0, 0.0, 0.0) if timing.motion is None else timing.motion.error
                appears[pair] = max(appears[pair], timing.appears)
                expires[pair] = min(expires[pair], timing.expires)
    changes[[pair for pair, _ in pairs.allowances]] = False
    for shared in (changes, errors, appears, expires):
        shared.setflags(write=False)
    return ChangingPairs(changes, pairs.required, errors, appears, expires)
