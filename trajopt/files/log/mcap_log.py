"""A log in MCAP: messages in JSON with their times and topics, of Foxglove's schemas and two of our own.

Viewers know Foxglove's messages by their names; https://docs.foxglove.dev/docs/sdk/schemas describes them.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from math import isfinite
from pathlib import Path
from typing import TypeAlias

from trajopt.values.documents.files import written_whole
from trajopt.values.errors import MissingExtra, ProblemError

Json: TypeAlias = dict[str, object]

NUMBER: Json = {"type": "number"}
INTEGER: Json = {"type": "integer"}
TEXT: Json = {"type": "string"}
FLAG: Json = {"type": "boolean"}


def array(items: Json) -> Json:
    return {"type": "array", "items": items}


def record(title: str, **fields: Json) -> Json:
    return {"title": title, "type": "object", "properties": fields}


@dataclass(frozen=True, eq=False)
class Topic:
    """A channel of a log."""

    name: str
    schema: Json


TIME = record("time", sec=INTEGER, nsec=INTEGER)
DURATION = record("duration", sec=INTEGER, nsec=INTEGER)
VECTOR = record("foxglove.Vector3", x=NUMBER, y=NUMBER, z=NUMBER)
QUATERNION = record("foxglove.Quaternion", x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER)
POSE = record("foxglove.Pose", position=VECTOR, orientation=QUATERNION)
COLOR = record("foxglove.Color", r=NUMBER, g=NUMBER, b=NUMBER, a=NUMBER)
UNUSED = array(record("unused"))
"""A list that is always empty."""

FRAME_TRANSFORMS = record(
    "foxglove.FrameTransforms",
    transforms=array(
        record(
            "foxglove.FrameTransform",
            timestamp=TIME,
            parent_frame_id=TEXT,
            child_frame_id=TEXT,
            translation=VECTOR,
            rotation=QUATERNION,
        )
    ),
)
SCENE_ENTITY = record(
    "foxglove.SceneEntity",
    timestamp=TIME,
    frame_id=TEXT,
    id=TEXT,
    lifetime=DURATION,
    frame_locked=FLAG,
    metadata=UNUSED,
    arrows=UNUSED,
    cubes=array(record("foxglove.CubePrimitive", pose=POSE, size=VECTOR, color=COLOR)),
    spheres=array(record("foxglove.SpherePrimitive", pose=POSE, size=VECTOR, color=COLOR)),
    cylinders=array(
        record(
            "foxglove.CylinderPrimitive",
            pose=POSE,
            size=VECTOR,
            bottom_scale=NUMBER,
            top_scale=NUMBER,
            color=COLOR,
        )
    ),
    lines=UNUSED,
    triangles=array(
        record(
            "foxglove.TriangleListPrimitive",
            pose=POSE,
            points=array(VECTOR),
            color=COLOR,
            colors=UNUSED,
            indices=array(INTEGER),
        )
    ),
    texts=UNUSED,
    models=UNUSED,
)
SCENE_UPDATE = record(
    "foxglove.SceneUpdate",
    deletions=array(record("foxglove.SceneEntityDeletion", timestamp=TIME, type=INTEGER, id=TEXT)),
    entities=array(SCENE_ENTITY),
)
JOINT_STATES = record(
    "foxglove.JointStates",
    timestamp=TIME,
    joints=array(
        record("foxglove.JointState", name=TEXT, position=NUMBER, velocity=NUMBER, acceleration=NUMBER)
    ),
)
LOG = record("foxglove.Log", timestamp=TIME, level=INTEGER, message=TEXT, name=TEXT, file=TEXT, line=INTEGER)
MOTION = record(
    "Motion",
    begin=TIME,
    joint_names=array(TEXT),
    times=array(NUMBER),
    positions=array(array(NUMBER)),
    velocities=array(array(NUMBER)),
    accelerations=array(array(NUMBER)),
)
"""A motion: times since `begin` [s], and a row for each of them, in rad or m; unknown lists are empty."""
DECISION = record(
    "Decision",
    timestamp=TIME,
    outcome=TEXT,
    reason=TEXT,
    unchanged=INTEGER,
    joint_names=array(TEXT),
    commanded=array(array(NUMBER)),
)
"""A decision of a guard; see `trajopt.driving.Decision`."""

FRAMES = Topic("/tf", FRAME_TRANSFORMS)
SCENE = Topic("/scene", SCENE_UPDATE)
JOINTS = Topic("/joint_states", JOINT_STATES)
PLAN = Topic("/plan", MOTION)
COMMITTED = Topic("/committed", MOTION)
EVENTS = Topic("/events", LOG)
DECISIONS = Topic("/decisions", DECISION)


def stamp(time: float) -> Json:
    """Return a time, not negative, as Foxglove's messages contain it."""
    sec, nsec = divmod(_nanoseconds(time), 1_000_000_000)
    return {"sec": sec, "nsec": nsec}


class McapLog:
    """A log that is written to a file when it is complete; https://mcap.dev describes the format."""

    def __init__(self) -> None:
        try:
            from mcap.writer import Writer
        except ImportError as error:
            raise MissingExtra("mcap", "mcap") from error
        self._bytes, self._channels = BytesIO(), dict[Topic, int]()
        self._writer = Writer(self._bytes)
        self._writer.start(library="trajopt")

    def add(self, topic: Topic, time: float, message: Mapping[str, object]) -> None:
        """Add a message at a time, not negative [s]."""
        at = _nanoseconds(time)
        if topic not in self._channels:
            name, data = str(topic.schema["title"]), json.dumps(topic.schema).encode()
            schema = self._writer.register_schema(name=name, encoding="jsonschema", data=data)
            self._channels[topic] = self._writer.register_channel(
                topic=topic.name, message_encoding="json", schema_id=schema
            )
        data = json.dumps(message, allow_nan=False, separators=(",", ":")).encode()
        self._writer.add_message(self._channels[topic], log_time=at, publish_time=at, data=data)

    def save(self, path: Path | str) -> None:
        """Write the file atomically; nothing can be added afterwards."""
        self._writer.finish()
        with written_whole(path) as draft:
            draft.write_bytes(self._bytes.getvalue())


def _nanoseconds(time: float) -> int:
    if not isfinite(time) or time < 0.0:
        raise ProblemError(f"a time of a log must be finite and not negative, is {time:g} s")
    return round(1e9 * time)
