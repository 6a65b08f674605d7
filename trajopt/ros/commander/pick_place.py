"""Picking and placing in MoveIt's words: grasp and place messages, and the execution of what is planned."""

from dataclasses import replace
from typing import Any

from trajopt.files.messages import document_of, is_message
from trajopt.files.moveit.frames import world_names
from trajopt.files.moveit.pose import read_vector
from trajopt.files.moveit.robot_state import layered_positions
from trajopt.ros.commander.conversions import framed_placement
from trajopt.ros.commander.world import World
from trajopt.scene.scene import Scene
from trajopt.server.move_group.execution import Execution
from trajopt.server.move_group.outcome import MoveItCommanderException
from trajopt.tasks.grasping import Grasp, Gripper, PickPlaceResult, Place, Straight
from trajopt.values.arrays import Floats
from trajopt.values.placement import WORLD


def grasp_of(message: Any, name: str, scene: Scene, gripper: Gripper, *, link: str, at: Floats) -> Grasp:
    """Return a grasp as a Grasp message says it.

    Args:
        message: The message; its pose is of the end effector, its postures are of the fingers.
        name: The object.
        scene: The scene.
        gripper: The gripper.
        link: The end effector.
        at: Positions of all joints now [rad | m].

    Raises:
        MoveItCommanderException: If a posture leaves a finger out.
    """
    where, frame = framed_placement(message.grasp_pose, WORLD)
    placed = scene.placement_of(_frame(frame, scene), at) * where
    tool = scene.placement_of(link, at).inverse() * scene.placement_of(gripper.tool, at)
    return Grasp(
        placement=scene.placement_of(name, at).inverse() * placed * tool,
        width=_opening(message.grasp_posture, "grasp_posture", scene, gripper),
        opening=_opening(message.pre_grasp_posture, "pre_grasp_posture", scene, gripper),
        approach=_straight(message.pre_grasp_approach, link),
        lift=_straight(message.post_grasp_retreat, link),
        name=message.id or "grasp",
    )


def place_of(location: Any, scene: Scene, *, link: str, at: Floats) -> Place:
    """Return a place as a Pose, PoseStamped or PlaceLocation says it: where the object will be.

    Args:
        location: The message.
        scene: The scene.
        link: The end effector.
        at: Positions of all joints now [rad | m].
    """
    whole = is_message(location, "place_pose")
    where, frame = framed_placement(location.place_pose if whole else location, WORLD)
    placed = scene.placement_of(_frame(frame, scene), at) * where
    if not whole:
        return Place(placement=placed)
    return Place(
        placement=placed,
        lower=_straight(location.pre_place_approach, link),
        retreat=_straight(location.post_place_retreat, link),
        name=location.id or "place",
    )


def executed(result: PickPlaceResult, world: World, tip: str) -> bool:
    """Execute all motions of a pick or place in order, and update the scene.

    Returns:
        Whether the robot got to the end of every one; the world's outcome is that of the last.
    """
    for segment in result.require():
        reduced = segment.result.problem.reduced
        execution = Execution(reduced, segment.trajectory, tip)
        if not world.execute(execution, wait=True).reached:
            return False
    item = result.final_scene.object(result.name)
    world.edit(lambda scene: replace(scene, objects={**scene.objects, item.name: item}))
    return True


def _frame(name: str, scene: Scene) -> str:
    return WORLD if name in world_names(scene.robot) else name


def _straight(message: Any, link: str) -> Straight:
    """Return a straight motion; the usual one where the message leaves it open."""
    direction = read_vector(document_of(message.direction.vector, "direction")) or (0.0, 0.0, 0.0)
    distance = float(message.desired_distance)
    if not any(direction):
        return Straight(distance) if distance > 0.0 else Straight()
    frame = str(message.direction.header.frame_id).removeprefix("/") or link
    return Straight(distance, direction, frame)


def _opening(posture: Any, name: str, scene: Scene, gripper: Gripper) -> float:
    """Return how far apart a posture has the pads [m]."""
    robot, points = scene.robot, posture.points
    if not points or len(points[-1].positions) != len(posture.joint_names):
        raise MoveItCommanderException(
            f"{name}: give a position for each of {', '.join(gripper.joint_names)}"
        )
    named = dict(zip(posture.joint_names, points[-1].positions, strict=True))
    missing = [joint for joint in gripper.joint_names if joint not in named]
    if missing:
        raise MoveItCommanderException(f"{name}: leaves out {', '.join(missing)}")
    return gripper.opening_at(robot, layered_positions(robot, named))
