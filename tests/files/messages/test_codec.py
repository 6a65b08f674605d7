"""Messages as documents and back, in both of ROS' ways."""

import json
from dataclasses import fields
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trajopt.files.messages import (
    CollisionObject,
    Constraints,
    Duration,
    Float64,
    Generation,
    GetCartesianPathRequest,
    Header,
    JointTrajectoryPoint,
    Mesh,
    MotionPlanRequest,
    MoveItErrorCodes,
    PlanningScene,
    Pose,
    PoseStamped,
    PositionIKRequest,
    Quaternion,
    RobotState,
    SolidPrimitive,
    Time,
    UInt8,
    decode,
    definitions,
    document_of,
    encode,
    message_named,
    name_of,
)
from trajopt.values.errors import FileFormatError, MessageNotFound

EVERY = [message_named(name) for name in sorted(definitions())]


@pytest.mark.parametrize("generation", Generation)
@pytest.mark.parametrize("kind", EVERY, ids=name_of)
def test_every_message_survives_json(kind: type[Any], generation: Generation) -> None:
    document = json.loads(json.dumps(encode(kind(), generation), allow_nan=False))
    assert decode(kind, document, generation) == kind()
    assert document_of(kind(), "message").value is not None


@pytest.mark.parametrize("kind", EVERY, ids=name_of)
def test_missing_fields_take_ros_defaults(kind: type[Any]) -> None:
    assert decode(kind, {}) == kind() == decode(kind, None)


@pytest.mark.parametrize("kind", EVERY, ids=name_of)
def test_an_unknown_field_is_refused_by_name(kind: type[Any]) -> None:
    with pytest.raises(FileFormatError, match=r"has no field 'colour_of_paint'"):
        decode(kind, {"colour_of_paint": 1})


@pytest.mark.parametrize("kind", EVERY, ids=name_of)
def test_a_field_of_another_kind_is_refused_by_name(kind: type[Any]) -> None:
    for member in fields(kind):
        with pytest.raises(FileFormatError, match=rf"{member.name}|seconds"):
            decode(kind, {member.name: {"not": "this"}})


def test_times_are_taken_in_both_spellings() -> None:
    for document in (
        {"sec": 2, "nanosec": 500_000_000},
        {"secs": 2, "nsecs": 500_000_000},
        {"secs": 2, "nanosec": 500_000_000},
        {"secs": 2.5},
        2.5,
    ):
        assert decode(Duration, document) == Duration(2.5)
    assert decode(Time, "now").to_sec() > 1.6e9


def test_times_are_written_in_each_way() -> None:
    header = Header(7, Time(2, 5), "world")
    assert encode(header) == {"stamp": {"sec": 2, "nanosec": 5}, "frame_id": "world"}
    old = {"seq": 7, "stamp": {"secs": 2, "nsecs": 5}, "frame_id": "world"}
    assert encode(header, Generation.ROS1) == old
    assert decode(Header, old) == header


def test_a_quaternion_without_w_takes_the_default_of_its_ros() -> None:
    assert decode(Quaternion, {"x": 0.5}).w == 1.0
    assert decode(Quaternion, {"x": 0.5}, Generation.ROS1).w == 0.0
    assert decode(Pose, {}).orientation == Quaternion()


def test_null_is_missing_but_no_number() -> None:
    assert decode(PoseStamped, {"header": None, "pose": {"position": None}}) == PoseStamped()
    with pytest.raises(FileFormatError, match=r"pose\.position\.x: must be a number, is null"):
        decode(PoseStamped, {"pose": {"position": {"x": None}}})


@pytest.mark.parametrize(
    ("kind", "document", "complaint"),
    [
        (Pose, {"position": {"x": "1"}}, r"position\.x: must be a number, is '1'"),
        (Pose, {"position": {"x": True}}, r"position\.x: must be a number, is True"),
        (Pose, {"position": {"x": float("nan")}}, r"position\.x: must be a number"),
        (Pose, {"position": 3}, r"position: must be a geometry_msgs/Point, is 3"),
        (Pose, {"position": [1, 2, 3, 4]}, r"position: geometry_msgs/Point has 3 fields, not 4"),
        (Constraints, {"joint_constraints": {}}, r"joint_constraints: must be a list, is \{\}"),
        (
            Constraints,
            {"joint_constraints": [{}, {"joint_name": 3}]},
            r"\[1\]\.joint_name: must be text, is 3",
        ),
        (
            Mesh,
            {"triangles": [{"vertex_indices": [0, 1, -1]}]},
            r"vertex_indices\[2\]: must be a whole number",
        ),
        (SolidPrimitive, {"type": 2.5}, "type: must be a whole number from 0 to 255, is 2.5"),
        (UInt8, {"data": 256}, "data: must be a whole number from 0 to 255, is 256"),
        (UInt8, {"data": 10**400}, "data: must be a whole number from 0 to 255, is a whole"),
        (Float64, {"data": -(10**400)}, "data: exceeds numbers of 64 bits"),
        (MoveItErrorCodes, {"val": float("inf")}, "val: must be a whole number"),
        (Header, {"stamp": {"sec": float("inf")}}, "stamp: must count seconds"),
        (Header, {"stamp": {"second": 1}}, "stamp: builtin_interfaces/Time has no field 'second'"),
        (RobotState, {"is_diff": "yes"}, "is_diff: must be true or false, is 'yes'"),
        (PlanningScene, [], None),
        (PlanningScene, "all", "must be a moveit_msgs/PlanningScene, is 'all'"),
    ],
)
def test_messages_of_other_types_are_refused(
    kind: type[Any], document: object, complaint: str | None
) -> None:
    if complaint is None:
        assert decode(kind, document) == kind()
        return
    with pytest.raises(FileFormatError, match=complaint):
        decode(kind, document, name="/apply_planning_scene")


def test_a_whole_number_may_be_written_with_a_point() -> None:
    operation = decode(CollisionObject, {"operation": 3.0}).operation
    assert operation == CollisionObject.MOVE and isinstance(operation, int)


def test_a_number_that_json_cannot_write_is_null() -> None:
    document = encode(JointTrajectoryPoint([float("nan"), 1.0]))
    assert isinstance(document, dict)
    assert document["positions"] == [None, 1.0]


def test_fields_of_both_generations_are_known() -> None:
    assert decode(PositionIKRequest, {"attempts": 8, "timeout": {"secs": 2, "nsecs": 0}}).attempts == 8
    assert decode(GetCartesianPathRequest, {"jump_threshold": 1.57}).jump_threshold == 1.57
    assert decode(MotionPlanRequest, {"pipeline_id": "ompl"}).pipeline_id == "ompl"
    assert decode(CollisionObject, {"type": {"key": "", "db": ""}}).type.key == ""


def test_names() -> None:
    assert message_named("std_msgs/String") is message_named("std_msgs/msg/String")
    assert message_named("duration") is Duration
    assert name_of(PlanningScene) == "moveit_msgs/PlanningScene"
    assert name_of(PlanningScene, between="msg") == "moveit_msgs/msg/PlanningScene"
    with pytest.raises(MessageNotFound, match="did you mean 'std_msgs/String'"):
        message_named("std_msgs/Strin")


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.just(10**400) | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(["header", "stamp", "sec", "pose", "position", "x", "id", "meshes", "vertices"]),
            inner,
            max_size=4,
        )
    ),
    max_leaves=12,
)


@settings(max_examples=200, deadline=None)
@given(JSON)
def test_any_document_is_taken_or_refused_in_a_sentence(document: object) -> None:
    try:
        message = decode(CollisionObject, document)
    except FileFormatError as error:
        assert str(error)
    else:
        assert json.dumps(encode(message), allow_nan=False)
