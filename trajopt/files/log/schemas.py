"""JSON schemas of the messages of a log: those of Foxglove that it uses, and two of our own.

Viewers know Foxglove's messages by their names; https://docs.foxglove.dev/docs/sdk/schemas describes them.
"""

from dataclasses import dataclass
from typing import TypeAlias

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
