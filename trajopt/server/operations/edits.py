"""Edits of a scene, in the words of the Python API: `{"add": {"name": "table", "shape": {"box": {...}}}}`."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, cast

from trajopt.files.moveit.frames import reading_at
from trajopt.files.moveit.planning_scene import edit_scene
from trajopt.files.moveit.robot_state import layered_positions, read_joint_positions
from trajopt.scene.scene import Scene
from trajopt.server.operations.words import called, value_of
from trajopt.server.state import SessionState
from trajopt.values.arrays import floats
from trajopt.values.documents.document import Node
from trajopt.values.errors import FileFormatError, ModelError, ProblemError

SCENE_EDITS: Mapping[str, Callable[..., Scene]] = {
    "add": Scene.add,
    "remove": Scene.remove,
    "move": Scene.move,
    "attach": Scene.attach,
    "detach": Scene.detach,
    "allow": Scene.allow,
    "allow_contact": Scene.allow_contact,
    "with_clearance": Scene.with_clearance,
    "with_margin": Scene.with_margin,
    "with_cloud": Scene.with_cloud,
    "with_motion": Scene.with_motion,
    "with_tool": Scene.with_tool,
}
"""Methods of a scene that a request can name."""
STAND = "stand"
"""Puts the robot somewhere: the name of a state, joint -> position [rad | m], or positions of all joints."""


def edited(state: SessionState, edits: Node) -> SessionState:
    """Return the session's content after edits, in order.

    Args:
        state: The content.
        edits: A list of mappings, each with the name of an edit and its arguments. An attached or detached
            object keeps its present place, unless `placement` or `at` is given.

    Raises:
        FileFormatError: If an edit is unknown, or its arguments are invalid.
        ModelError: If an edit is impossible; all or none of them are made.
    """
    for node in edits.elements():
        keys = node.only((*SCENE_EDITS, STAND)).keys()
        if len(keys) != 1:
            raise node.error("must hold one edit")
        try:
            state = _once(state, keys[0], node[keys[0]])
        except FileFormatError:
            raise  # it names its place
        except (ModelError, ProblemError) as error:
            raise node.error(str(error)) from error
    return state


def _once(state: SessionState, edit: str, node: Node) -> SessionState:
    if edit == STAND:
        return stand(state, node)
    given: dict[str, object] = {"self": state.scene}
    if edit == "detach" or (edit == "attach" and not node.has("placement")):
        given["at"] = state.positions
    if "self" in node.keys():
        raise node.error("unknown key self")
    return replace(state, scene=called(SCENE_EDITS[edit], node, **given))


def stand(state: SessionState, node: Node) -> SessionState:
    """Return the session's content with the robot at other positions: see `STAND`."""
    where: Any = value_of(node)
    robot = state.scene.robot
    if isinstance(where, tuple):
        given_positions = floats(STAND, cast("tuple[float, ...]", where), (len(robot.joint_names),))
        return replace(state, positions=robot.followed(given_positions))
    return replace(state, positions=robot.positions(where))


def scene_of_message(state: SessionState, message: Node) -> tuple[SessionState, tuple[str, ...]]:
    """Return the session's content after a `moveit_msgs/PlanningScene`, and notes on its interpretation.

    Args:
        state: The content.
        message: The message; it replaces the scene unless it `is_diff`.

    Raises:
        FileFormatError: If the message is malformed, unsupported, or has an octomap.
        NameNotFound: If it names an unknown link, frame or object.
    """
    robot, notes = state.scene.robot, list[str]()
    told = read_joint_positions(message["robot_state"], robot, notes)
    positions = layered_positions(robot, state.named_positions, told)
    scene = edit_scene(message, state.scene, reading_at(state.scene, positions, notes))
    return replace(state, scene=scene, positions=positions), tuple(notes)
