"""What a camera publishes as `sensor_msgs/PointCloud2`, in place of what it published before."""

from dataclasses import replace

import numpy as np

from trajopt.files.messages import document_of
from trajopt.files.messages.sensor_msgs import PointCloud2, PointField
from trajopt.files.moveit.frames import read_frame
from trajopt.lab.perception import PointCloud, perceive
from trajopt.ros.rosbridge.answers.service_call import read_call, reading_in
from trajopt.server.operation import Answer
from trajopt.server.refusals import Refusal, Why
from trajopt.server.state import SessionState
from trajopt.server.watch import Watch
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node
from trajopt.values.errors import FileFormatError

NUMBERS = {PointField.FLOAT32: "f4", PointField.FLOAT64: "f8"}
"""How coordinates may be written."""
OF_SENSORS = "cloud"
"""What the names of objects begin with that are clouds, before the sensor's frame."""


def point_cloud(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Put a cloud into the scene in place of the last one of that sensor, without the robot in it.

    The object is named by the sensor's frame. A message that is older than the newest is left out; one whose
    stamp is 0 has none.

    Raises:
        FileFormatError: If the message does not say what it must.
        FrameNotFound: If its frame is unknown.
        Refusal: If it has too many points.
    """
    message = read_call(PointCloud2, arguments, watch).message
    if message.width * message.height > watch.cloud:
        raise Refusal(
            Why.TOO_LARGE, f"a cloud has {watch.cloud} points at most, not {message.width * message.height}"
        )
    header, reading = document_of(message.header, "header"), reading_in(state.scene, state.positions)
    frame = read_frame(header, state.scene, reading)
    name, stamp = f"{OF_SENSORS} {frame}", message.header.stamp.to_sec()
    if stamp and stamp < state.stamps.get(name, -np.inf):
        return Answer({})
    sensor = PointCloud(points_of(message), state.positions, frame)
    scene = perceive(state.scene, sensor, name=name).scene
    return Answer({}, replace(state, scene=scene, stamps={**state.stamps, name: stamp}))


def points_of(message: PointCloud2) -> Floats:
    """Return the points of a message, shape (n, 3) [m]; those that were not measured are not finite.

    Raises:
        FileFormatError: If its fields, its sizes and its data do not fit together.
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
