"""The planning scene: `/get_planning_scene`, `/apply_planning_scene`, and topics that edit it."""

from dataclasses import replace

from trajopt.files.messages import document_of
from trajopt.files.messages.moveit_msgs import (
    ApplyPlanningSceneRequest,
    ApplyPlanningSceneResponse,
    AttachedCollisionObject,
    CollisionObject,
    GetPlanningSceneRequest,
    GetPlanningSceneResponse,
)
from trajopt.files.moveit.attached_object import apply_attached
from trajopt.files.moveit.scene_edits import edit_object, edit_scene
from trajopt.files.moveit.state_message import scene_message
from trajopt.ros.rosbridge.answers.service_call import positions_in, read_call, reading_in
from trajopt.server.operation import Answer
from trajopt.server.state import SessionState
from trajopt.server.watch import Watch
from trajopt.values.documents.document import Node

ALL = 2**32 - 1
"""What is asked for where a request says nothing, as in MoveIt: all components."""


def get_planning_scene(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Return the scene, as much of it as is asked for."""
    request = read_call(GetPlanningSceneRequest, arguments, watch)
    components = request.message.components.components or ALL
    return request.answer(GetPlanningSceneResponse(scene_message(state.scene, state.positions, components)))


def apply_planning_scene(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Replace the scene, or change it where the message is a difference; the robot stands where it says."""
    request = read_call(ApplyPlanningSceneRequest, arguments, watch)
    message = request.message.scene
    positions = positions_in(message.robot_state, state, "scene.robot_state")
    document = document_of(message, "scene")
    scene = edit_scene(document, state.scene, reading_in(state.scene, positions))
    changed = replace(state, scene=scene, positions=positions)
    return request.answer(ApplyPlanningSceneResponse(success=True), changed)


def edit_collision_object(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Do what a collision object message on a topic says."""
    request = read_call(CollisionObject, arguments, watch)
    document = document_of(request.message, "collision object")
    scene = edit_object(document, state.scene, reading_in(state.scene, state.positions))
    return Answer({}, replace(state, scene=scene))


def edit_attached_object(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Do what an attached collision object message on a topic says."""
    request = read_call(AttachedCollisionObject, arguments, watch)
    document = document_of(request.message, "attached object")
    scene = apply_attached(document, state.scene, reading_in(state.scene, state.positions))
    return Answer({}, replace(state, scene=scene))
