"""The planning scene: MoveIt's services, topics that edit the scene, and clouds of cameras."""

from dataclasses import replace

import numpy as np

from trajopt.files.messages import (
    ApplyPlanningSceneRequest,
    ApplyPlanningSceneResponse,
    AttachedCollisionObject,
    CollisionObject,
    GetPlanningSceneRequest,
    GetPlanningSceneResponse,
    PointCloud2,
    PointField,
    document_of,
)
from trajopt.files.moveit.frames import read_frame, reading_at
from trajopt.files.moveit.objects import apply_attached
from trajopt.files.moveit.planning_scene import edit_object, edit_scene
from trajopt.files.moveit.scene_messages import scene_message
from trajopt.lab.perception import PointCloud, perceive
from trajopt.ros.rosbridge.answers.service_call import positions_in, read_call
from trajopt.server.operation import Answer
from trajopt.server.refusals import Refusal, Why
from trajopt.server.state import SessionState
from trajopt.server.watch import Watch
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node
from trajopt.values.errors import FileFormatError

ALL = 2**32 - 1
"""All components, the default of MoveIt's requests."""
NUMBERS = {PointField.FLOAT32: "f4", PointField.FLOAT64: "f8"}
"""Numeric types of coordinates."""
OF_SENSORS = "cloud"
"""Prefix of the names of point cloud objects, followed by the sensor's frame."""


def get_planning_scene(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Return the requested components of the scene."""
    request = read_call(GetPlanningSceneRequest, arguments, watch)
    components = request.message.components.components or ALL
    return request.answer(GetPlanningSceneResponse(scene_message(state.scene, state.positions, components)))


def apply_planning_scene(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Replace the scene, or apply a difference; the robot takes the message's positions."""
    request = read_call(ApplyPlanningSceneRequest, arguments, watch)
    message = request.message.scene
    positions = positions_in(message.robot_state, state, "scene.robot_state")
    document = document_of(message, "scene")
    scene = edit_scene(document, state.scene, reading_at(state.scene, positions))
    changed = replace(state, scene=scene, positions=positions)
    return request.answer(ApplyPlanningSceneResponse(success=True), changed)


def edit_collision_object(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Apply a collision object message from a topic."""
    request = read_call(CollisionObject, arguments, watch)
    document = document_of(request.message, "collision object")
    scene = edit_object(document, state.scene, reading_at(state.scene, state.positions))
    return Answer({}, replace(state, scene=scene))


def edit_attached_object(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Apply an attached collision object message from a topic."""
    request = read_call(AttachedCollisionObject, arguments, watch)
    document = document_of(request.message, "attached object")
    scene = apply_attached(document, state.scene, reading_at(state.scene, state.positions))
    return Answer({}, replace(state, scene=scene))


def point_cloud(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Replace the last point cloud of a sensor in the scene, without points on the robot.

    The object's name contains the sensor's frame. A message older than the newest is ignored; stamp 0 means
    no stamp.

    Raises:
        FileFormatError: If the message is incomplete or malformed.
        FrameNotFound: If its frame is unknown.
        Refusal: If it has too many points.
    """
    message = read_call(PointCloud2, arguments, watch).message
    if message.width * message.height > watch.cloud:
        raise Refusal(
            Why.TOO_LARGE, f"a cloud has {watch.cloud} points at most, not {message.width * message.height}"
        )
    header, reading = document_of(message.header, "header"), reading_at(state.scene, state.positions)
    frame = read_frame(header, state.scene, reading)
    name, stamp = f"{OF_SENSORS} {frame}", message.header.stamp.to_sec()
    if stamp and stamp < state.stamps.get(name, -np.inf):
        return Answer({})
    sensor = PointCloud(points_of(message), state.positions, frame)
    scene = perceive(state.scene, sensor, name=name).scene
    return Answer({}, replace(state, scene=scene, stamps={**state.stamps, name: stamp}))


def points_of(message: PointCloud2) -> Floats:
    """Return the points of a message, shape (n, 3) [m]; unmeasured points are not finite.

    Raises:
        FileFormatError: If its fields, sizes and data are inconsistent.
    """
    width, height, step, row = message.width, message.height, message.point_step, message.row_step
    fields = {each.name: each for each in message.fields}
    if not {"x", "y", "z"} <= fields.keys():
        raise _wrong("fields must have x, y and z")
    order = ">" if message.is_bigendian else "<"
    formats = list[str]()
    for name in "xyz":
        field = fields[name]
        if field.datatype not in NUMBERS or field.count != 1:
            raise _wrong(f"{name} must be one FLOAT32 or FLOAT64")
        formats.append(order + NUMBERS[field.datatype])
        if field.offset + np.dtype(formats[-1]).itemsize > step:
            raise _wrong(f"{name} does not lie in a point of {step} bytes")
    if row < width * step or row * height != len(message.data):
        raise _wrong(
            f"{height} rows of {row} bytes, {width} points of {step} in each: {len(message.data)} bytes"
        )
    if not width * height:
        return np.empty((0, 3))
    rows = np.frombuffer(message.data, np.uint8).reshape(height, row)[:, : width * step]
    layout = np.dtype(
        {
            "names": list("xyz"),
            "formats": formats,
            "offsets": [fields[name].offset for name in "xyz"],
            "itemsize": step,
        }
    )
    points = np.ascontiguousarray(rows).reshape(-1).view(layout)
    return np.stack([points[name].astype(np.float64) for name in "xyz"], axis=1)


def _wrong(reason: str) -> FileFormatError:
    return FileFormatError("PointCloud2", reason)
