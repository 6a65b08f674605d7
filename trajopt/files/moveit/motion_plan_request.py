"""Motion plan request messages, MoveIt's description of a planning problem."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from trajopt.files.messages import MotionPlanRequest, TrajectoryConstraints, field_names
from trajopt.files.moveit.constraints import read_constraints
from trajopt.files.moveit.frames import Reading, require, world_names
from trajopt.files.moveit.objects import apply_attached
from trajopt.files.moveit.planning_scene import SceneFile
from trajopt.files.moveit.scene_messages import (
    layered_positions,
    placed_robot,
    read_joint_positions,
    read_workspace,
)
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import Requirement, any_of
from trajopt.problem.tool_speed import ToolSpeed, tool_speed
from trajopt.robot.loading.groups import ALL_JOINTS
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Value
from trajopt.values.documents.document import Node, read_document
from trajopt.values.errors import FrameNotFound, GroupNotFound
from trajopt.values.errors.arguments import checked

IGNORED = ("planner_id", "pipeline_id", "num_planning_attempts", "reference_trajectories")
LIMITED_LINK = ("cartesian_speed_limited_link", "cartesian_speed_end_effector_link")
"""Fields that name the link of limited speed, in current and old MoveIt."""


@dataclass(frozen=True, eq=False)
class RequestFile(Value):
    """The content of a motion plan request file.

    Attributes:
        scene: Including objects attached in the start state.
        start: Positions of all joints, shape (number of joints,) [rad | m].
        alternatives: Alternative goals by name, if the file has several; any one suffices.
        acceleration_scaling: Factor in (0, 1], as `velocity_scaling`.
        allowed_planning_time: Planning time [s]; None if not given.
        notes: Sentences on omissions and deviations from the file.
    """

    path: Path
    scene: Scene
    start: Floats
    group: str
    goals: tuple[Requirement, ...]
    alternatives: Mapping[str, tuple[Requirement, ...]]
    constraints: tuple[Requirement, ...]
    waypoints: tuple[tuple[Requirement, ...], ...]
    velocity_scaling: float
    acceleration_scaling: float
    tool_speed: tuple[ToolSpeed, ...]
    allowed_planning_time: float | None
    notes: tuple[str, ...]

    def problem(self) -> Problem:
        return Problem(
            scene=self.scene,
            start=self.start,
            goal=any_of(self.alternatives) if self.alternatives else self.goals,
            group=self.group,
            constraints=self.constraints,
            waypoints=self.waypoints,
            velocity_scaling=self.velocity_scaling,
            acceleration_scaling=self.acceleration_scaling,
            tool_speed=self.tool_speed,
            name=self.path.stem,
        )


@checked
def read_request(path: Path | str, scene: SceneFile | Scene) -> RequestFile:
    """Read a `moveit_msgs/MotionPlanRequest` from YAML.

    Joints missing from the start state take their positions from the scene file, or else their defaults. The
    workspace restricts only a mobile base.

    Raises:
        FileFormatError: If the file is incomplete or malformed.
        NameNotFound: If it names a joint, link, frame, object or group that does not exist.
    """
    document = read_document(path)
    if isinstance(scene, Scene):
        return request_of(document, scene)
    return request_of(document, scene.scene, scene.state, scene.world_names)


def request_of(
    document: Node,
    scene: Scene,
    state: Mapping[str, float] | None = None,
    frames: frozenset[str] | None = None,
) -> RequestFile:
    """Read a motion plan request message, as `read_request` reads a file.

    Args:
        state: Joint -> position, for joints that the start state leaves out [rad | m]; others are at their
            default.
        frames: Frame ids of the world; see `world_names` when None.
    """
    document.only(field_names(MotionPlanRequest))
    notes: list[str] = []
    names = world_names(scene.robot) if frames is None else frames
    robot = placed_robot(document["start_state"]["multi_dof_joint_state"], scene.robot, notes)
    around = scene
    if robot is not scene.robot:
        names = names.difference(scene.robot.links[:1]) | world_names(robot)
        around = replace(scene, robot=robot)
    stated = read_joint_positions(document["start_state"], robot, notes)
    start = layered_positions(robot, state or {}, stated)
    reading = Reading(names, start, notes=notes)
    for node in document["start_state"]["attached_collision_objects"].elements():
        around = apply_attached(node, around, reading)
    group = _read_group(document["group_name"], robot, notes)
    goals, around = _read_goals(document["goal_constraints"], around, reading)
    constraints, around = read_constraints(document["path_constraints"], around, reading)
    room = read_workspace(document["workspace_parameters"], robot, group, names, notes)
    waypoints: list[tuple[Requirement, ...]] = []
    passed = document["trajectory_constraints"].only(field_names(TrajectoryConstraints))
    for node in passed["constraints"].elements():
        wanted, around = read_constraints(node, around, reading)
        if not wanted:
            raise node.error("requires nothing")
        waypoints.append(wanted)
    notes.extend(f"{key}: is ignored" for key in IGNORED if document[key].value)
    return RequestFile(
        path=Path(document.path),
        scene=around,
        start=start,
        group=group,
        goals=next(iter(goals.values())),
        alternatives=goals if len(goals) > 1 else {},
        constraints=(*constraints, *room),
        waypoints=tuple(waypoints),
        velocity_scaling=_read_scaling(document["max_velocity_scaling_factor"]),
        acceleration_scaling=_read_scaling(document["max_acceleration_scaling_factor"]),
        tool_speed=_read_tool_speed(document, around, notes),
        allowed_planning_time=_read_time(document["allowed_planning_time"]),
        notes=tuple(notes),
    )


def _read_tool_speed(document: Node, scene: Scene, notes: list[str]) -> tuple[ToolSpeed, ...]:
    limit = document["max_cartesian_speed"].number(0.0)
    if limit <= 0.0:
        return ()
    for key in LIMITED_LINK:
        link = document[key].text("")
        if link:
            require(document[key], FrameNotFound, "frame", link, (*scene.frame_names, *scene.objects))
            return (tool_speed(link, linear=limit),)
    notes.append(f"max_cartesian_speed: is ignored, {LIMITED_LINK[0]} names no link")
    return ()


def _read_goals(
    node: Node, scene: Scene, reading: Reading
) -> tuple[Mapping[str, tuple[Requirement, ...]], Scene]:
    found: dict[str, tuple[Requirement, ...]] = {}
    for place, goal in enumerate(node.elements(), start=1):
        requirements, scene = read_constraints(goal, scene, reading)
        if not requirements:
            raise goal.error("requires nothing")
        name = goal["name"].text("") or f"goal {place}"
        if name in found:
            raise goal["name"].error(f"{name!r} is the name of two goals")
        found[name] = requirements
    if not found:
        raise node.error("names no goal")
    return found, scene


def _read_group(node: Node, robot: Robot, notes: list[str]) -> str:
    name = node.text("")
    if name in robot.left_out and name not in robot.groups:
        raise GroupNotFound(
            f"group (at {node.place} in {node.path})", name, robot.groups, left_out=robot.left_out[name]
        )
    if tuple(robot.groups) == (ALL_JOINTS,):
        if name not in ("", ALL_JOINTS):
            notes.append(f"{node.place}: {name!r} needs the robot's SRDF; all joints are planned for")
        return ALL_JOINTS
    if not name and len(robot.groups) == 1:
        return next(iter(robot.groups))
    require(node, GroupNotFound, "group", name, robot.groups)
    return name


def _read_scaling(node: Node) -> float:
    value = node.number(0.0)
    if not 0.0 <= value <= 1.0:
        raise node.error(f"must lie in (0, 1], or be 0 for the default of 1; is {value:g}")
    return value or 1.0


def _read_time(node: Node) -> float | None:
    value = node.number(0.0)
    return value if value > 0.0 else None
