"""Reading and editing a session's scene, and adding clouds of points."""

import io
from collections.abc import Callable, Mapping
from dataclasses import replace
from tokenize import TokenError
from typing import Any, cast

import numpy as np

from trajopt.files.moveit.frames import reading_at
from trajopt.files.moveit.planning_scene import apply_motions, edit_scene
from trajopt.files.moveit.scene_messages import layered_positions, read_joint_positions
from trajopt.lab.perception import PointCloud, Sensing, perceive
from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import SceneObject
from trajopt.server.limits import RequestRefused, Why
from trajopt.server.operation import Answer, SessionState, Watch
from trajopt.server.operations.words import SHAPES, called, value_of
from trajopt.values.arrays import Floats, floats
from trajopt.values.documents.document import Node
from trajopt.values.errors import FileFormatError, ModelError, ProblemError
from trajopt.values.placement import Placement
from trajopt.values.shapes.clouds import Points
from trajopt.values.shapes.shapes import Shape


def edit(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Change the scene: `{"edits": [...]}`."""
    edits = arguments.only(("edits",))["edits"]
    if watch.driven and any(node.has(STAND) for node in edits.elements()):
        raise RequestRefused(Why.BUSY, "the robot is being driven: it cannot be put elsewhere; stop it first")
    state = edited(state, edits)
    return Answer(_description(state), state)


def set_motions(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Set motions and existence of objects: `{"motions": [...]}`, in the format of `--motions`."""
    scene = apply_motions(arguments.only(("motions",))["motions"], state.scene)
    state = replace(state, scene=scene)
    return Answer(_description(state), state)


def planning_scene(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Apply a `moveit_msgs/PlanningScene`: the whole scene, or its changes if it `is_diff`.

    The robot takes joint positions in it, unless it is being driven.
    """
    before = state
    state, notes = scene_of_message(state, arguments)
    if watch.driven:
        state = replace(state, positions=before.positions)
        notes = (*notes, "the robot is being driven: the positions of the message are ignored")
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
    return {"xyz": where.translation.tolist(), "quaternion": where.quaternion.tolist()}


def _shape(shape: Shape) -> dict[str, Any]:
    sizes = vars(shape)
    kept = ("x", "y", "z", "radius", "length", "vertices", "points", "faces", "keys", "size")
    plain = {key: getattr(sizes[key], "tolist", lambda key=key: sizes[key])() for key in kept if key in sizes}
    return {type(shape).__name__.lower(): plain}


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
STAND = "stand"
"""Puts the robot somewhere: the name of a state, joint -> position [rad | m], or positions of all joints."""


def edited(state: SessionState, edits: Node) -> SessionState:
    """Return the session's content after edits, in order; all or none of them are made.

    Args:
        edits: A list of mappings, each with the name of an edit and its arguments. An attached or detached
            object keeps its present place, unless `placement` or `at` is given.
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
    if edit == "add" and isinstance(node["shape"].value, dict):
        node["shape"].only(SHAPES)
    return replace(state, scene=called(SCENE_EDITS[edit], node, **given))


def stand(state: SessionState, node: Node) -> SessionState:
    where: Any = value_of(node)
    robot = state.scene.robot
    if isinstance(where, tuple):
        given_positions = floats(STAND, cast("tuple[float, ...]", where), (len(robot.joint_names),))
        return replace(state, positions=robot.followed(given_positions))
    return replace(state, positions=robot.positions(where))


def scene_of_message(state: SessionState, message: Node) -> tuple[SessionState, tuple[str, ...]]:
    robot, notes = state.scene.robot, list[str]()
    told = read_joint_positions(message["robot_state"], robot, notes)
    positions = layered_positions(robot, state.named_positions, told)
    scene = edit_scene(message, state.scene, reading_at(state.scene, positions, notes))
    return replace(state, scene=scene, positions=positions), tuple(notes)


MAGIC = b"\x93NUMPY"
"""First bytes of numpy's files. As numbers of a plain cloud they would be 220,000 km away."""
KINDS = ("<f4", "<f8")
COORDINATES = 3
CAMERA = "camera"


def cloud(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Add a cloud of points to the scene, or replace the earlier cloud of that name.

    The body is float32 (little-endian) x, y, z of each point [m], or numpy's .npy of float32 or float64 with
    shape (n, 3) or more columns; application/octet-stream. The address has the arguments: `name`; `radius` of
    the ball of each point, in world coordinates [m]; or, without it, the arguments of `PointCloud`
    (`positions`, `frame`, `placement`, `nearest`, `farthest`, `spacing`) and of `Sensing` (`cell`, `padding`,
    `sigmas`, `known`), with which the robot itself is removed. `stamp` [s]: older measurements than the
    newest are ignored.
    """
    points = points_in(watch.attachment, watch.cloud)
    name = arguments["name"].text(CAMERA)
    stamp = arguments["stamp"].number() if arguments.has("stamp") else None
    if stamp is not None and stamp < state.stamps.get(name, -np.inf):
        return Answer({"taken": False, "points": len(points), "newest": state.stamps[name]})
    if arguments.has("radius"):
        arguments.only(("name", "stamp", "radius"))
        radius = arguments["radius"].number()
        measured = points[np.isfinite(points).all(axis=1)]
        scene = state.scene.with_cloud(name, Points(measured, radius) if len(measured) else None)
        told: dict[str, object] = {"balls": len(measured), "radius": radius}
    else:
        sensor, sensing = _sensor(arguments, points, state)
        seen = perceive(state.scene, sensor, sensing, name=name)
        scene = seen.scene
        told = {"balls": len(seen.cloud.keys), "radius": seen.cloud.radius.whole, **seen.cloud.counts}
    stamps = state.stamps if stamp is None else {**state.stamps, name: stamp}
    return Answer({"taken": True, "points": len(points), **told}, replace(state, scene=scene, stamps=stamps))


def points_in(data: bytes, most: int) -> Floats:
    found = _of_numpy(data) if data.startswith(MAGIC) else _of_numbers(data)
    if len(found) > most:
        raise RequestRefused(Why.TOO_LARGE, f"a cloud has {most} points at most, not {len(found)}")
    return found[:, :COORDINATES].astype(np.float64)


def _of_numbers(data: bytes) -> Any:
    size = COORDINATES * 4
    if len(data) % size:
        raise RequestRefused(
            Why.MALFORMED, f"the cloud has {len(data)} bytes, and a point has {size}: x, y, z as float32"
        )
    return np.frombuffer(data, "<f4").reshape(-1, COORDINATES)


def _of_numpy(data: bytes) -> Any:
    stream, layout = io.BytesIO(data), cast("Any", np.lib.format)
    try:
        version = layout.read_magic(stream)
        read = layout.read_array_header_1_0 if version == (1, 0) else layout.read_array_header_2_0
        shape, fortran, kind = read(stream)
    except (ValueError, TypeError, SyntaxError, TokenError, RecursionError, MemoryError) as error:
        raise RequestRefused(Why.MALFORMED, f"the cloud is not an .npy file: {error}") from error
    if fortran or kind.str not in KINDS or len(shape) != 2 or shape[1] < COORDINATES:
        raise RequestRefused(
            Why.MALFORMED,
            f"the cloud needs float32 or float64 in rows of x, y, z, and is {kind.str} of shape {shape}",
        )
    begin = stream.tell()
    if shape[0] < 0 or shape[0] * shape[1] * kind.itemsize != len(data) - begin:
        raise RequestRefused(
            Why.MALFORMED, f"the cloud has shape {shape} in its header, but {len(data) - begin} bytes"
        )
    return np.frombuffer(data, kind, offset=begin).reshape(shape)


_SENSOR = ("frame", "placement", "nearest", "farthest", "spacing")
_SENSING = ("cell", "padding", "sigmas", "known")


def _sensor(arguments: Node, points: Floats, state: SessionState) -> tuple[PointCloud, Sensing]:
    arguments.only(("name", "stamp", "radius", "positions", *_SENSOR, *_SENSING))
    parts = [
        Node({key: each.value for key, each in arguments.members().items() if key in names}, arguments.path)
        for names in (_SENSOR, _SENSING)
    ]
    stood = stand(state, arguments["positions"]) if arguments.has("positions") else state
    return called(PointCloud, parts[0], points=points, positions=stood.positions), called(Sensing, parts[1])
