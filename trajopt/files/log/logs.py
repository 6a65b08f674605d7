"""Logs: messages with their times and topics, of Foxglove's schemas and two of our own.

Schemas: https://docs.foxglove.dev/docs/sdk/schemas.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from io import BytesIO
from math import isfinite
from pathlib import Path
from typing import Any, Protocol, TypeAlias

import numpy as np

from trajopt.values.arrays import Floats, Ints
from trajopt.values.documents.files import written_whole
from trajopt.values.errors import MissingExtra, ProblemError
from trajopt.values.placement import Placement, from_quaternion

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


class Log(Protocol):
    """A log written to a file when it is complete."""

    def add(self, topic: Topic, time: float, message: Mapping[str, Any]) -> None:
        """Add a message at a time, not negative [s]."""
        ...

    def save(self, path: Path | str) -> None:
        """Write the file atomically; nothing can be added afterwards."""
        ...


class McapLog:
    """A log in MCAP, with messages in JSON; https://mcap.dev describes the format."""

    def __init__(self) -> None:
        try:
            from mcap.writer import Writer
        except ImportError as error:
            raise MissingExtra("mcap", "mcap") from error
        self._bytes, self._channels = BytesIO(), dict[Topic, int]()
        self._writer = Writer(self._bytes)
        self._writer.start(library="trajopt")

    def add(self, topic: Topic, time: float, message: Mapping[str, Any]) -> None:
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
        self._writer.finish()
        with written_whole(path) as draft:
            draft.write_bytes(self._bytes.getvalue())


LEVELS = {2: "INFO", 3: "WARN", 4: "ERROR"}
"""Rerun's names of the levels of Foxglove's log messages."""
SIDES = 24
"""Sides of the mesh of a cone."""


class RerunLog:
    """A log for Rerun's viewer, in which the world is `/world`; https://rerun.io describes it."""

    def __init__(self) -> None:
        try:
            self._rerun: Any = import_module("rerun")
        except ImportError as error:
            raise MissingExtra("rerun", "rerun") from error
        self._recording = self._rerun.RecordingStream("trajopt")
        self._bytes, self._shown = self._recording.binary_stream(), set[str]()
        self._recording.set_log_time_enabled(False)  # the only time is the log's
        self._recording.set_log_tick_enabled(False)
        self._recording.send_blueprint(self._layout())
        self._writers: dict[Topic, Callable[[Mapping[str, Any]], None]] = {
            JOINTS: self._joints,
            FRAMES: self._frames,
            SCENE: self._scene,
            EVENTS: lambda event: self._text(EVENTS, event["message"], LEVELS[event["level"]]),
            DECISIONS: lambda each: self._text(DECISIONS, f"{each['outcome']}: {each['reason']}", "INFO"),
            PLAN: lambda motion: self._motion(PLAN, motion),
            COMMITTED: lambda motion: self._motion(COMMITTED, motion),
        }
        self._shapes: dict[str, Callable[[Mapping[str, Any]], Any]] = {
            "cubes": self._cube,
            "spheres": self._sphere,
            "cylinders": self._cylinder,
            "triangles": self._triangles,
        }

    def add(self, topic: Topic, time: float, message: Mapping[str, Any]) -> None:
        self._at(time)
        self._writers[topic](message)

    def save(self, path: Path | str) -> None:
        self._recording.flush()
        with written_whole(path) as draft:
            draft.write_bytes(self._bytes.read())

    def _layout(self) -> Any:
        views: Any = import_module("rerun.blueprint")
        plot = views.TimeSeriesView(origin="joint_states/position", name="joint positions")
        beside = views.Vertical(plot, views.TextLogView(contents="/**", name="events"))
        world = views.Spatial3DView(origin="world", name="world")
        return views.Blueprint(views.Horizontal(world, beside), collapse_panels=True)

    def _at(self, time: float) -> None:
        self._recording.set_time("time", duration=_nanoseconds(time) / 1e9)

    def _text(self, topic: Topic, text: str, level: str) -> None:
        self._recording.log(topic.name, self._rerun.TextLog(text, level=level))

    def _number(self, topic: Topic, names: list[str], value: float) -> None:
        # A path as a list may have any name in it.
        self._recording.log([topic.name.removeprefix("/"), *names], self._rerun.Scalars([value]))

    def _joints(self, message: Mapping[str, Any]) -> None:
        for joint in message["joints"]:
            for order, value in joint.items():
                if order != "name":
                    self._number(JOINTS, [order, joint["name"]], value)

    def _motion(self, topic: Topic, message: Mapping[str, Any]) -> None:
        begin = message["begin"]["sec"] + 1e-9 * message["begin"]["nsec"]
        for time, row in zip(message["times"], message["positions"], strict=True):
            self._at(begin + time)
            for name, value in zip(message["joint_names"], row, strict=True):
                self._number(topic, [name], value)

    def _frames(self, message: Mapping[str, Any]) -> None:
        for each in message["transforms"]:
            there = self._rerun.Transform3D(
                translation=_numbers(each["translation"]), quaternion=_numbers(each["rotation"])
            )
            self._recording.log(["world", each["child_frame_id"]], there)

    def _scene(self, message: Mapping[str, Any]) -> None:
        entities = {each["id"]: each for each in message["entities"]}
        for name in self._shown - entities.keys():
            self._recording.log(["world", name], self._rerun.Clear(recursive=True))
        self._shown = set(entities)
        for name, entity in entities.items():
            shapes = [(kind, shape) for kind in self._shapes for shape in entity[kind]]
            for number, (kind, shape) in enumerate(shapes):
                self._recording.log(["world", name, str(number)], self._shapes[kind](shape))

    def _cube(self, shape: Mapping[str, Any]) -> Any:
        return self._rerun.Boxes3D(sizes=[_numbers(shape["size"])], **self._placed(shape))

    def _sphere(self, shape: Mapping[str, Any]) -> Any:
        halves = [value / 2.0 for value in _numbers(shape["size"])]
        return self._rerun.Ellipsoids3D(half_sizes=[halves], **self._placed(shape))

    def _cylinder(self, shape: Mapping[str, Any]) -> Any:
        width, _, length = _numbers(shape["size"])
        if shape["top_scale"] == 0.0:
            return self._mesh(shape, *_cone(width / 2.0, length))
        return self._rerun.Cylinders3D(lengths=[length], radii=[width / 2.0], **self._placed(shape))

    def _triangles(self, shape: Mapping[str, Any]) -> Any:
        points = np.array([_numbers(point) for point in shape["points"]])
        return self._mesh(shape, points, np.array(shape["indices"]).reshape(-1, 3))

    def _mesh(self, shape: Mapping[str, Any], points: Floats, faces: Ints) -> Any:
        pose = shape["pose"]
        at = Placement(from_quaternion(*_numbers(pose["orientation"])), np.array(_numbers(pose["position"])))
        return self._rerun.Mesh3D(
            vertex_positions=at * points, triangle_indices=faces, albedo_factor=_colour(shape)
        )

    def _placed(self, shape: Mapping[str, Any]) -> dict[str, Any]:
        pose = shape["pose"]
        return {
            "centers": [_numbers(pose["position"])],
            "quaternions": [_numbers(pose["orientation"])],
            "colors": [_colour(shape)],
            "fill_mode": self._rerun.components.FillMode.Solid,
        }


def _numbers(record: Mapping[str, float]) -> list[float]:
    return list(record.values())


def _colour(shape: Mapping[str, Any]) -> list[int]:
    return [round(255 * value) for value in _numbers(shape["color"])]


def _cone(radius: float, length: float) -> tuple[Floats, Ints]:
    angles, rim = np.linspace(0.0, 2.0 * np.pi, SIDES, endpoint=False), np.arange(SIDES)
    bottom = np.full(SIDES, -length / 2.0)
    circle = np.column_stack((radius * np.cos(angles), radius * np.sin(angles), bottom))
    points = np.vstack((circle, (0.0, 0.0, length / 2.0), (0.0, 0.0, -length / 2.0)))
    following, tip = np.roll(rim, -1), np.full(SIDES, SIDES)
    sides, base = np.column_stack((rim, following, tip)), np.column_stack((following, rim, tip + 1))
    return points, np.concatenate((sides, base))


def _nanoseconds(time: float) -> int:
    if not isfinite(time) or time < 0.0:
        raise ProblemError(f"a time of a log must be finite and not negative, is {time:g} s")
    return round(1e9 * time)
