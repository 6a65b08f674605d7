"""Stand-in for `moveit.task_constructor.stages`."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, cast

import numpy as np
from scipy.spatial.transform import Rotation

from trajopt.files.messages import document_of, is_message
from trajopt.files.moveit.constraints import read_constraints
from trajopt.files.moveit.frames import frame_named, reading_at
from trajopt.files.moveit.planning_scene import edit_object
from trajopt.files.moveit.scene_messages import checked_joint_positions
from trajopt.problem.requirements import Requirement, follows_curve, frame_placement
from trajopt.robot.joints import EXCESS
from trajopt.robot.robot import Robot
from trajopt.ros.commander.conversions import framed_placement
from trajopt.ros.commander.moveit.core.planning_scene import PlanningScene
from trajopt.ros.commander.moveit.task_constructor.core import (
    CartesianPath,
    PlannerInterface,
    Stage,
    StageContext,
)
from trajopt.ros.commander.world import group_named
from trajopt.scene.scene import Scene
from trajopt.tasks import stages as ours
from trajopt.tasks.cartesian.curves import line
from trajopt.tasks.cartesian.following import FollowOptions
from trajopt.tasks.grasping import grasp as grasping
from trajopt.tasks.grasping.grasp import Grasp, Straight
from trajopt.tasks.grasping.gripper import Gripper, arm_of, gripper_of
from trajopt.tasks.grasping.stages import PickObject, PlaceObject
from trajopt.tasks.result import TaskSegment
from trajopt.tasks.search import Leg, TaskSearch, TaskStage, TaskState, Way
from trajopt.tasks.sequence import StageRefusal
from trajopt.values.arrays import Floats, Value, floats
from trajopt.values.placement import WORLD, Placement, placement
from trajopt.values.shapes.shapes import placed_box

Goal = Mapping[str, float] | Placement
"""Joint -> position [rad | m], or a placement in the world."""
SceneEdit = Callable[[Scene, Floats], Scene]
"""Returns a scene changed, for a robot at positions of all joints [rad | m]."""


@dataclass(frozen=True, eq=False)
class FromState(Value):
    """A stage whose ways depend on the state before it."""

    name: str
    found: Callable[[str, TaskSearch, TaskState], Iterator[Way]]
    default_name = "stage"

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        del scene, group
        return held

    def ways(self, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        yield from self.found(self.name, search, state)


def _required_of(constraints: Any, scene: Scene, at: Floats) -> tuple[tuple[Requirement, ...], Scene]:
    if constraints is None:
        return (), scene
    return read_constraints(document_of(constraints, "path_constraints"), scene, reading_at(scene, at))


def _frame_of(header: Any, scene: Scene, at: Floats) -> Placement:
    return scene.placement_of(frame_named(header.frame_id.removeprefix("/"), scene.robot), at)


def _vector_of(message: Any) -> Floats:
    return floats("direction", (message.x, message.y, message.z), (3,))


class CurrentState(Stage):
    """The state of the world."""

    def __init__(self, name: str = "current state") -> None:
        super().__init__(name)

    def _translated(self, context: StageContext) -> list[TaskStage]:
        return [FromState(self.name, lambda _, search, state: iter((search.rested(state),)))]


class FixedState(CurrentState):
    """The state of a PlanningScene."""

    def __init__(self, name: str = "fixed state") -> None:
        super().__init__(name)

    def setState(self, scene: PlanningScene) -> None:
        self._given = scene

    def _translated(self, context: StageContext) -> list[TaskStage]:
        given: PlanningScene = self._required()
        context.scene, context.positions = given.scene, given.current_state.positions
        return super()._translated(context)


class ModifyPlanningScene(Stage):
    """Changes of the scene, in the order of the calls; those between attachments are judged together."""

    def __init__(self, name: str = "modify planning scene") -> None:
        super().__init__(name)
        self._changes: list[TaskStage | list[SceneEdit]] = []

    def addObject(self, collision_object: Any) -> None:
        document = document_of(collision_object, "collision object")
        self._edit(lambda scene, at: edit_object(document, scene, reading_at(scene, at)))

    def removeObject(self, name: str) -> None:
        self._edit(lambda scene, _: scene.remove(name))

    def allowCollisions(self, first: Any, second: Any = True, enable_collision: bool = True) -> None:
        """Allow or forbid contact of links and objects, or of one with anything."""
        if isinstance(second, bool):
            second, enable_collision = (None,), second
        for one in _several(first):
            for other in _several(second):
                self._edit(lambda scene, _, a=one, b=other: scene.allow(a, b, allowed=enable_collision))

    def attachObjects(self, names: Any, attach_link: str, attach: bool = True) -> None:
        for name in _several(names):
            change = (
                ours.AttachObject(name, attach_link, (attach_link,), within=np.inf)
                if attach
                else ours.DetachObject(name)
            )
            self._changes.append(change)

    def detachObjects(self, names: Any, attach_link: str) -> None:
        self.attachObjects(names, attach_link, attach=False)

    attachObject, detachObject = attachObjects, detachObjects

    def _edit(self, change: SceneEdit) -> None:
        if not self._changes or not isinstance(self._changes[-1], list):
            self._changes.append([])
        cast("list[SceneEdit]", self._changes[-1]).append(change)

    def _translated(self, context: StageContext) -> list[TaskStage]:
        return [self._edited(item) if isinstance(item, list) else item for item in self._changes]

    def _edited(self, edits: Sequence[SceneEdit]) -> TaskStage:
        def ways(name: str, search: TaskSearch, state: TaskState) -> Iterator[Way]:
            def change(scene: Scene) -> Scene:
                for edit in edits:
                    scene = edit(scene, state.positions)
                return scene

            yield ours.changed(search, state, change, name)

        return FromState(self.name, ways)


def _several(names: Any) -> Sequence[Any]:
    return (names,) if isinstance(names, str) else names


class Connect(Stage):
    """The motion to the next stage."""

    declared: ClassVar[Mapping[str, Any]] = {
        "merge_mode": None,
        "max_distance": 0.0,
        "path_constraints": None,
    }

    def __init__(self, name: str = "connect", planners: Sequence[tuple[str, PlannerInterface]] = ()) -> None:
        super().__init__(name)
        self._planners = planners

    def _translated(self, context: StageContext) -> list[TaskStage]:
        for group, planner in self._planners:
            if isinstance(planner, CartesianPath):
                raise self._refusal("has no straight lines: use MoveTo with CartesianPath")
            context.moves(group, planner)
        context.on_the_way = self.path_constraints
        return []


@dataclass(frozen=True, eq=False)
class _Move:
    """A motion to a goal that the state before decides.

    Attributes:
        least: Returns the fraction of a line of a length [m] that has to be followed.
    """

    group: str
    link: str
    goal: Callable[[Scene, Floats], Goal]
    constraints: Any = None
    least: Callable[[float], float] = lambda _: 1.0

    def freely(self, name: str, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        robot, goal = state.scene.robot, self.goal(state.scene, state.positions)
        kept, scene = _required_of(self.constraints, state.scene, state.positions)
        own = robot.group(self.group).joints
        wanted = frame_placement(self.link, goal) if isinstance(goal, Placement) else None
        there = state.positions if isinstance(goal, Placement) else _reached(state, goal)
        if wanted is not None or set(own) <= set(robot.group(search.group).joints):
            joints = dict(zip(own, there[robot.index(own)].tolist(), strict=True))
            move = ours.MoveTo(wanted or joints, name, kept, self.group)
            move.held_after(scene, search.group, frozenset())
            yield from move.ways(search, replace(state, scene=scene))
        else:
            bare = replace(scene, margin=0.0, pair_margins={}, kind_margins={})
            yield state.rest().to(Leg(name, there, bare, group=self.group)).rest()

    def straight(self, name: str, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        begin = state.scene.placement_of(self.link, state.positions)
        goal = self.goal(state.scene, state.positions)
        if not isinstance(goal, Placement):
            goal = state.scene.placement_of(self.link, _reached(state, goal))
        if np.allclose(begin.homogeneous, goal.homogeneous):
            yield state
            return
        options = FollowOptions(
            velocity_scaling=search.options.velocity_scaling,
            acceleration_scaling=search.options.acceleration_scaling,
        )
        curve = follows_curve(self.link, line(begin, goal))
        found = ours.followed(search, state, curve, options, group=self.group)
        if not found.verified or found.fraction < self.least(curve.until):
            yield StageRefusal(name, found.status, found.reason, found.result)
        else:
            yield state.through(TaskSegment((name,), found.result))


def _reached(state: TaskState, joints: Mapping[str, float]) -> Floats:
    robot, moved = state.scene.robot, np.array(state.positions)
    moved[robot.index(list(joints))] = list(joints.values())
    return robot.followed(moved)


class _Motion(Stage):
    declared: ClassVar[Mapping[str, Any]] = {"group": "", "ik_frame": None, "path_constraints": None}

    def __init__(self, name: str, planner: PlannerInterface) -> None:
        super().__init__(name)
        self._planner = planner

    def _ends(self, scene: Scene, at: Floats, link: str) -> Goal:
        raise NotImplementedError

    def _least(self, length: float) -> float:
        least = float(self._planner.min_fraction)
        if least > 1.0:
            raise self._refusal(f"follows at most the whole line, less than min_fraction {least:g}")
        return least

    def _translated(self, context: StageContext) -> list[TaskStage]:
        group = context.moves(self.group, self._planner)
        link = context.tool(self.ik_frame, group)
        straight, kept = isinstance(self._planner, CartesianPath), self.path_constraints
        if straight and kept is not None:
            raise self._refusal("keeps no path_constraints with CartesianPath: use PipelinePlanner")
        move = _Move(group, link, lambda scene, at: self._ends(scene, at, link), kept, self._least)
        return [FromState(self.name, move.straight if straight else move.freely)]


class MoveTo(_Motion):
    """A motion of a group to a goal."""

    def setGoal(self, goal: Any) -> None:
        """Set a named state, joint -> position, PoseStamped, PointStamped or RobotState."""
        self._given = goal

    def _translated(self, context: StageContext) -> list[TaskStage]:
        self._joints(context.scene.robot)
        return super()._translated(context)

    def _merged(self, context: StageContext) -> ours.MoveTo:
        joints = self._joints(context.scene.robot)
        if joints is None or self.path_constraints is not None:
            return super()._merged(context)
        return ours.MoveTo(joints, self.name, group=context.moves(self.group, self._planner))

    def _joints(self, robot: Robot) -> dict[str, float] | None:
        goal = self._required()
        if isinstance(goal, str):
            goal = robot.state(goal, group=group_named(robot, self.group).name)
        elif is_message(goal, "joint_state"):
            goal = checked_joint_positions(document_of(goal, "robot state"), robot)
        if not isinstance(goal, Mapping):
            return None
        joints = cast("Mapping[str, float]", goal)
        return {joint: value for joint, value in joints.items() if joint not in robot.mimics}

    def _ends(self, scene: Scene, at: Floats, link: str) -> Goal:
        joints, goal = self._joints(scene.robot), self._required()
        if joints is not None:
            return joints
        frame = _frame_of(goal.header, scene, at)
        if is_message(goal, "header", "pose"):
            return frame * framed_placement(goal, WORLD)[0]
        return placement(frame * _vector_of(goal.point), rotation=scene.placement_of(link, at).rotation)


class MoveRelative(_Motion):
    """A motion relative to the state before it."""

    declared: ClassVar[Mapping[str, Any]] = {"min_distance": -1.0, "max_distance": 0.0}

    def setDirection(self, direction: Any) -> None:
        """Set a TwistStamped, Vector3Stamped, or joint -> offset [rad | m]."""
        self._given = direction

    def _ends(self, scene: Scene, at: Floats, link: str) -> Goal:
        goal = self._required()
        if isinstance(goal, Mapping):
            offsets = cast("Mapping[str, float]", goal)
            here = dict(zip(offsets, at[scene.robot.index(list(offsets))].tolist(), strict=True))
            return {joint: here[joint] + offset for joint, offset in offsets.items()}
        turned, here = _frame_of(goal.header, scene, at).rotation, scene.placement_of(link, at)
        twist = is_message(goal, "twist")
        along = turned @ _vector_of(goal.twist.linear if twist else goal.vector)
        about = turned @ _vector_of(goal.twist.angular) if twist else np.zeros(3)
        if self.max_distance > 0.0:
            if about.any():
                raise self._refusal("takes max_distance without rotation only: give the twist its length")
            along = along * (self.max_distance / float(np.linalg.norm(along)))
        turn = Rotation.from_rotvec(about).as_matrix()
        return placement(here.translation + along, rotation=turn @ here.rotation)

    def _least(self, length: float) -> float:
        if self.min_distance < 0.0:
            return super()._least(length)
        if self.min_distance > length + EXCESS:
            raise self._refusal(
                f"moves {length:.3g} m, less than its min_distance of {self.min_distance:g} m"
            )
        return min(self.min_distance / length, 1.0)


class GeneratePose(Stage):
    """A pose for ComputeIK."""

    declared: ClassVar[Mapping[str, Any]] = {"pose": None}

    def setMonitoredStage(self, stage: Stage) -> None:
        """Do nothing."""

    def _translated(self, context: StageContext) -> list[TaskStage]:
        return []


class GeneratePlacePose(GeneratePose):
    """The pose of an object for Place."""

    declared: ClassVar[Mapping[str, Any]] = {"object": "", "eef": ""}

    def __init__(self, name: str = "Generate Place Pose") -> None:
        super().__init__(name)


class GenerateGraspPose(GeneratePlacePose):
    """Grasps of an object about its z axis for Pick."""

    declared: ClassVar[Mapping[str, Any]] = {"pregrasp": "", "grasp": "", "angle_delta": 0.1}


class ComputeIK(Stage):
    """A motion to the pose of a generator."""

    declared: ClassVar[Mapping[str, Any]] = {
        **{"eef": "", "group": "", "ik_frame": None, "target_pose": None, "default_pose": ""},
        **{"max_ik_solutions": 1, "min_solution_distance": 0.1},
    }

    def __init__(self, name: str, stage: Stage) -> None:
        super().__init__(name)
        self._generator = stage

    def _translated(self, context: StageContext) -> list[TaskStage]:
        pose = self.target_pose or self._generator.properties.get("pose")
        if pose is None:
            raise self._refusal("has no pose: use GeneratePose")
        effectors = context.scene.robot.end_effectors
        parent = effectors[self.eef].parent_group if self.eef in effectors else ""
        group = context.moves(self.group or parent or "")
        where, _ = framed_placement(pose, WORLD)
        move = _Move(
            group,
            context.tool(self.ik_frame, group),
            lambda scene, at: _frame_of(pose.header, scene, at) * where,
            context.taken_on_the_way(),
        )
        return [FromState(self.name, move.freely)]


class SimpleGrasp(Stage):
    """A grasp for Pick."""

    declared: ClassVar[Mapping[str, Any]] = {
        **{"eef": "", "object": "", "ik_frame": None},
        **{"pregrasp": "", "grasp": ""},
    }

    def __init__(self, pose_generator: Stage, name: str = "grasp") -> None:
        super().__init__(name)
        self._generator = pose_generator

    @property
    def generator(self) -> Stage:
        return self._generator

    def setIKFrame(self, frame: Any) -> None:
        """Set the frame between the pads, a PoseStamped or a link."""
        self.ik_frame = frame

    def setMaxIKSolutions(self, max_ik_solutions: int) -> None:
        """Do nothing."""


class SimpleUnGrasp(SimpleGrasp):
    """A release for Place."""

    def __init__(self, pose_generator: Stage, name: str = "ungrasp") -> None:
        super().__init__(pose_generator, name)


class _Handling(Stage):
    declared: ClassVar[Mapping[str, Any]] = dict.fromkeys(
        ("object", "eef", "eef_frame", "eef_group", "eef_parent_group"), ""
    )

    def __init__(self, fingers: SimpleGrasp, name: str) -> None:
        super().__init__(name)
        self._fingers = fingers
        self._lines: dict[str, tuple[Any, tuple[float, float]]] = {}

    def _stated(self, name: str) -> Any:
        """Return the first set property of the stage, its fingers and their generator."""
        stages = (self, self._fingers, self._fingers.generator)
        return next((value for stage in stages if (value := stage.properties.get(name))), None)

    def _gripper(self, context: StageContext) -> Gripper:
        frame = self._stated("ik_frame")
        tool = None if frame is None else context.tool(frame)
        gripper = gripper_of(context.scene, end_effector=self._stated("eef"), tool=tool)
        context.moves(arm_of(context.scene.robot, gripper))
        return gripper

    def _opening(self, posture: str, gripper: Gripper, robot: Robot) -> float | None:
        state = self._stated(posture)
        if state is None:
            return None
        joints = robot.state(state, group=gripper.group)
        moved = {joint: value for joint, value in joints.items() if joint not in robot.mimics}
        return min(gripper.opening_at(robot, robot.positions(moved)), gripper.widest)

    def _line(self, which: str, motion: Any, least: float, most: float) -> None:
        if isinstance(motion, Mapping) or _vector_of(motion.twist.angular).any():
            raise self._refusal("moves straight only: give a TwistStamped without rotation")
        self._lines[which] = motion, (least, most)

    def _straight(self, which: str, scene: Scene, *, far: bool) -> Straight:
        if which not in self._lines:
            return Straight()
        motion, distances = self._lines[which]
        frame = frame_named(motion.header.frame_id.removeprefix("/"), scene.robot)
        return Straight(distances[far], _vector_of(motion.twist.linear), frame)


class Pick(_Handling):
    """Approach, grasp and lift of an object."""

    def __init__(self, grasp_generator: SimpleGrasp, name: str = "pick") -> None:
        super().__init__(grasp_generator, name)

    def setApproachMotion(self, motion: Any, min_distance: float, max_distance: float) -> None:
        self._line("approach", motion, min_distance, max_distance)

    def setLiftMotion(self, motion: Any, min_distance: float, max_distance: float) -> None:
        self._line("lift", motion, min_distance, max_distance)

    def _translated(self, context: StageContext) -> list[TaskStage]:
        if not isinstance(self._fingers.generator, GenerateGraspPose):
            raise self._refusal("needs SimpleGrasp(GenerateGraspPose(...))")
        if context.taken_on_the_way() is not None:
            raise self._refusal("keeps no path_constraints of a Connect: ComputeIK and Place do")
        gripper, name = self._gripper(context), str(self._stated("object"))
        context.grippers[name] = gripper
        return [PickObject(name, self._grasps(context.scene, name, gripper), gripper, name=self.name)]

    def _grasps(self, scene: Scene, name: str, gripper: Gripper) -> list[Grasp]:
        """Return grasps about z: first with the longest motions, each from the narrowest."""
        opening = self._opening("pregrasp", gripper, scene.robot) or gripper.widest
        least = self._opening("grasp", gripper, scene.robot) or gripper.narrowest
        turns = np.arange(0.0, 2.0 * np.pi, self._stated("angle_delta")).tolist()
        held = {turn: placement(rpy=(0.0, 0.0, turn)) for turn in turns}
        widths = {turn: max(_width(scene, name, at * gripper.axes), least) for turn, at in held.items()}
        return [
            Grasp(
                placement=held[turn],
                width=widths[turn],
                opening=opening,
                force=grasping.usual_force(scene, name, gripper),
                approach=self._straight("approach", scene, far=far),
                lift=self._straight("lift", scene, far=far),
                name=f"turned by {np.rad2deg(turn):.0f} degrees",
            )
            for far in (True, False)
            for turn in sorted(turns, key=widths.__getitem__)
            if widths[turn] <= opening
        ]


def _width(scene: Scene, name: str, pads: Placement) -> float:
    """Return the extent along y of a placement in the object's frame [m]."""
    boxes = [placed_box(shape, pads.inverse() * where) for shape, where in scene.object(name).parts]
    return float(max(box[1, 1] for box in boxes) - min(box[0, 1] for box in boxes))


class Place(_Handling):
    """Carrying, lowering and release of an object, and the retreat from it."""

    def __init__(self, place_generator: SimpleGrasp, name: str = "place") -> None:
        super().__init__(place_generator, name)

    def setPlaceMotion(self, motion: Any, min_distance: float, max_distance: float) -> None:
        """Set the straight motion to the support [m]."""
        self._line("lower", motion, min_distance, max_distance)

    def setRetractMotion(self, motion: Any, min_distance: float, max_distance: float) -> None:
        """Set the straight motion off the object [m]."""
        self._line("retreat", motion, min_distance, max_distance)

    def _translated(self, context: StageContext) -> list[TaskStage]:
        pose, name = self._stated("pose"), str(self._stated("object"))
        if pose is None:
            raise self._refusal("needs SimpleUnGrasp(GeneratePlacePose(...)) with a pose")
        gripper = context.grippers.get(name) or self._gripper(context)
        held = context.scene.attach(name, gripper.tool, at=context.positions)
        kept, whole = _required_of(context.taken_on_the_way(), held, context.positions)
        frames = {key: item for key, item in whole.objects.items() if key not in held.objects}
        context.scene = replace(context.scene, objects={**context.scene.objects, **frames})
        where, frame = framed_placement(pose, WORLD)
        places = [
            grasping.Place(
                placement=where,
                frame=frame_named(frame, context.scene.robot),
                lower=self._straight("lower", context.scene, far=far),
                retreat=self._straight("retreat", context.scene, far=far),
            )
            for far in (True, False)
        ]
        opening = self._opening("pregrasp", gripper, context.scene.robot)
        return [PlaceObject(name, places, gripper, kept, name=self.name, opening=opening)]
