"""The robot with only a group's joints free, as used for planning, judging and simulation.

All other joints keep their start positions, even outside their limits. Data that depends only on the robot,
or only on one object, is computed once and shared by all scenes with it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
import pinocchio as pin

from trajopt.robot.bodies import Anchor, FixedBody
from trajopt.robot.limits import JointLimits
from trajopt.robot.loading.pinocchio_model import ModelData, configuration, model_data, model_of
from trajopt.scene.pairs import BodyPairs, CollisionModel, collision_model_of
from trajopt.scene.reduced_robot import reduce_robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, readonly
from trajopt.values.cached import cached_per_value
from trajopt.values.errors import FrameNotFound, ProblemError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement
from trajopt.values.printed import in_number

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class ReducedModel:
    """A scene's robot with only one group's joints free.

    Attributes:
        scene: The scene.
        group: Name of the group.
        start: Positions of all joints at the start, shape (number of joints,) [rad | m].
        model: Pinocchio's model of the free joints and of those that mimic them; never changed.
        joint_names: The group's joints, n of them.
        limits: Their limits, which respect those of the joints that mimic them.
        mimic_matrix: Matrix (model joints, n) that maps the group's positions to the model's.
        mimic_offset: Offsets of mimicking joints, shape (model joints,).
        collision_model: Its bodies, and the pairs that must keep apart.
    """

    scene: Scene
    group: str
    start: Floats
    model: pin.Model
    joint_names: tuple[str, ...]
    limits: JointLimits
    mimic_matrix: Floats
    mimic_offset: Floats
    collision_model: CollisionModel

    def __repr__(self) -> str:
        """Return the group, the number of free joints, and the scene."""
        return f"ReducedModel(group {self.group}, {in_number(self.joint_names, 'joint')}, {self.scene})"

    @property
    def bodies(self) -> tuple[FixedBody, ...]:
        """Collision bodies of links, then of objects."""
        return self.collision_model.bodies

    @property
    def pairs(self) -> BodyPairs:
        """The pairs of bodies that must keep apart."""
        return self.collision_model.pairs

    @property
    def anchors(self) -> Mapping[str, Anchor]:
        """Carrying joint and placement of each frame, object and the world, by name."""
        return self.collision_model.anchors

    def derived(self, build: Callable[["ReducedModel"], T]) -> T:
        """Return a function's result for this model, computed at the first call.

        All starts with the same fixed joints share it, so it must not depend on the group's start positions,
        nor refer to the model or its scene, which would then never be freed.
        """
        kept = _kept(self.collision_model)
        if build not in kept:
            kept[build] = build(self)
        return kept[build]

    def derived_of_robot(self, build: Callable[["ReducedModel"], T]) -> T:
        """Return a function's result for the robot alone, computed at the first call.

        All scenes with the same robot and the same fixed joints share it, so it must not depend on the
        objects of a scene or on the group's start positions, nor refer to the model.
        """
        kept = _kept_of_robot(self.model)
        if build not in kept:
            kept[build] = build(self)
        return kept[build]

    def __reduce__(self) -> tuple[Any, tuple[Any, ...]]:
        """Pickle by the scene; a model with a load is pickled whole."""
        robot = reduce_robot(self.scene.robot, self.group, self.start)
        loaded = None if self.model is robot.model else model_data(self.model)
        return _again, (self.scene, self.group, self.start, loaded)

    @property
    def moving_joints(self) -> tuple[str, ...]:
        """Names of the group's joints and of those that mimic them, in the model's order."""
        return self.derived_of_robot(_moving_joints)

    @cached_property
    def start_positions(self) -> Floats:
        """The group's positions at the start, shape (n,) [rad | m]."""
        return readonly(self.start[self.scene.robot.index(self.joint_names)])

    def configuration(self, positions: Floats) -> Floats:
        """Return pinocchio's configuration of the group's positions, (n,) -> (nq,)."""
        return configuration(self.model, self.mimic_matrix @ positions + self.mimic_offset)

    def all_positions(self, positions: Floats) -> Floats:
        """Return positions of all joints of the robot for the group's positions (n,)."""
        full = np.array(self.start)
        moved = self.mimic_matrix @ positions + self.mimic_offset
        full[self.scene.robot.index(self.moving_joints)] = moved
        return full

    def owners(self, pair: int) -> tuple[str, str]:
        """Return the links or objects of the bodies of a pair."""
        first, second = int(self.pairs.first[pair]), int(self.pairs.second[pair])
        return self.bodies[first].owner, self.bodies[second].owner

    def attachment(self, name: str) -> tuple[int, Placement]:
        """Return the joint (0: the world) that carries a frame or object, and its placement there.

        Raises:
            FrameNotFound: If the name is not a frame.
            ProblemError: If it moves by itself, so that its placement depends on the time.
        """
        found = self.anchors.get(name)
        if found is None and self.scene.carrier(name) is not None:
            raise ProblemError(f"{shown(name)} is moved by time: only `plan` and `judge` know where it is")
        if found is None:
            objects = self.scene.objects
            raise FrameNotFound("frame", name, self.anchors.keys() - objects.keys(), objects=objects)
        return found.joint, found.placement


@cached_per_value
def _kept(collision_model: CollisionModel) -> dict[Callable[[ReducedModel], Any], Any]:
    """Return the cache of derived results of models with these bodies."""
    del collision_model
    return {}


@cached_per_value
def _kept_of_robot(model: pin.Model) -> dict[Callable[[ReducedModel], Any], Any]:
    """Return the cache of derived results of robots with these free joints."""
    del model
    return {}


def _moving_joints(reduced: ReducedModel) -> tuple[str, ...]:
    return tuple(reduced.model.names[1:])


def _again(scene: Scene, group: str, start: Floats, loaded: ModelData | None) -> ReducedModel:
    reduced = reduce_model(scene, group, start)
    return reduced if loaded is None else replace(reduced, model=model_of(loaded))


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
