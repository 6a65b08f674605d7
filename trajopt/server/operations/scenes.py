"""Reading and changing a session's scene."""

from dataclasses import replace
from typing import Any

from trajopt.files.moveit.motions import apply_motions
from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import SceneObject
from trajopt.server.operation import Answer
from trajopt.server.operations.edits import STAND, edited, scene_of_message
from trajopt.server.refusals import Refusal, Why
from trajopt.server.state import SessionState
from trajopt.server.watch import Watch
from trajopt.values.documents.document import Node
from trajopt.values.placement import Placement
from trajopt.values.shapes.shapes import Shape


def edit(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Change the scene: `{"edits": [...]}`."""
    edits = arguments.only(("edits",))["edits"]
    if watch.driven and any(node.has(STAND) for node in edits.elements()):
        raise Refusal(Why.BUSY, "the robot is being driven: it cannot be put elsewhere; stop it first")
    state = edited(state, edits)
    return Answer(_description(state), state)


def set_motions(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Set motions and existence of objects: `{"motions": [...]}`, in the format of `--motions`."""
    scene = apply_motions(arguments.only(("motions",))["motions"], state.scene)
    state = replace(state, scene=scene)
    return Answer(_description(state), state)


def planning_scene(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Apply a `moveit_msgs/PlanningScene`: the whole scene, or its changes if it `is_diff`.

    Joint positions in it become those of the robot, unless it is being driven.
    """
    before = state
    state, notes = scene_of_message(state, arguments)
    if watch.driven:
        state = replace(state, positions=before.positions)
        notes = (*notes, "the robot is being driven: where it stands by the message does not count")
    return Answer({**_description(state), "notes": list(notes)}, state)


def read(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Return the content of the scene, and the robot's configuration."""
    arguments.only(())
    return Answer(_description(state))


def _description(state: SessionState) -> dict[str, object]:
    scene = state.scene
    return {
        "robot": state.robot,
        "positions": state.named_positions,
        "objects": {name: _object(item, scene) for name, item in scene.objects.items()},
    }


def _object(item: SceneObject, scene: Scene) -> dict[str, object]:
    return {
        "frame": item.frame,
        "placement": placement_document(item.placement),
        "attached_to": scene.holder(item.name).link,
        "parts": [{"shape": _shape(shape), "placement": placement_document(at)} for shape, at in item.parts],
        "mass": item.mass,
        "changes": not item.timing.always,
        "notes": list(item.notes),
    }


def placement_document(where: Placement) -> dict[str, list[float]]:
    """Return a placement as plain data: `xyz` [m] and `quaternion` (x, y, z, w)."""
    return {"xyz": where.translation.tolist(), "quaternion": where.quaternion.tolist()}


def _shape(shape: Shape) -> dict[str, Any]:
    """Return a shape as plain data, in the words in which it is stated."""
    sizes = vars(shape)
    kept = ("x", "y", "z", "radius", "length", "vertices", "points", "faces", "keys", "size")
    plain = {key: getattr(sizes[key], "tolist", lambda key=key: sizes[key])() for key in kept if key in sizes}
    return {type(shape).__name__.lower(): plain}
