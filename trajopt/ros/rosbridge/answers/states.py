"""MoveIt's services and topics of robot state, planning scene and clouds."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from trajopt.files import messages as msg
from trajopt.files.messages import document_of
from trajopt.files.moveit.constraints import read_constraints
from trajopt.files.moveit.frames import placement_in_world, pose_of, read_frame, read_placement, reading_at
from trajopt.files.moveit.objects import apply_attached
from trajopt.files.moveit.planning_scene import edit_object, edit_scene, without_collisions
from trajopt.files.moveit.scene_messages import scene_message, state_message
from trajopt.lab.perception import PointCloud, perceive
from trajopt.optimise.kinematics import inverse_kinematics, validity
from trajopt.problem.requirements import Requirement
from trajopt.ros.rosbridge.answers.service_call import (
    failed,
    positions_in,
    read_call,
    service,
    stated_in,
    success,
    with_notes,
)
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.server.limits import RequestRefused, Why
from trajopt.server.move_group.functions import held_pose
from trajopt.server.operation import Answer, SessionState, Watch
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node
from trajopt.values.errors import FileFormatError, FrameNotFound, GroupNotFound


def _placed(request: msg.GetPositionFKRequest, state: SessionState, _: Watch) -> msg.GetPositionFKResponse:
    stated, names = stated_in(request.robot_state, state, "robot_state"), request.fk_link_names
    scene, reading = stated.scene, stated.reading
    if not names:
        return msg.GetPositionFKResponse(
            error_code=failed(msg.MoveItErrorCodes.INVALID_LINK_NAME, "fk_link_names names no link")
        )
    known = (*scene.frame_names, *scene.objects)
    for name in names:
        if name not in known:
            raise FrameNotFound("link", name, known)
    frame = read_frame(document_of(request, "args")["header"], scene, reading)
    back = placement_in_world(frame, scene, reading).inverse()
    header = msg.Header(frame_id=request.header.frame_id or scene.robot.links[0])
    poses = [
        msg.PoseStamped(header, pose_of(back * placement_in_world(name, scene, reading))) for name in names
    ]
    return msg.GetPositionFKResponse(poses, list(names), with_notes(success(), reading.notes))


compute_fk = service(msg.GetPositionFKRequest, msg.GetPositionFKResponse, _placed)


def _searched(message: msg.GetPositionIKRequest, state: SessionState, _: Watch) -> msg.GetPositionIKResponse:
    request = message.ik_request
    robot, stated = state.scene.robot, stated_in(request.robot_state, state, "robot_state")
    near, reading = stated.positions, stated.reading
    if request.group_name not in robot.groups:
        raise GroupNotFound("group", request.group_name, robot.groups)
    scene = stated.scene if request.avoid_collisions else without_collisions(stated.scene)
    group = robot.group(request.group_name)
    document = document_of(request, "ik_request")
    links, poses = [request.ik_link_name], [document["pose_stamped"]]
    if request.ik_link_names or request.pose_stamped_vector:
        links, poses = list(request.ik_link_names), document["pose_stamped_vector"].elements()
    if len(links) != len(poses):
        raise document["pose_stamped_vector"].error(f"{len(poses)} poses for {len(links)} links")
    wanted: list[Requirement] = []
    for link, pose in zip(links, poses, strict=True):
        frame = placement_in_world(read_frame(pose["header"], scene, reading), scene, reading)
        name = _known(link or group.tip or "", scene)
        wanted.append(held_pose(name, frame * read_placement(pose["pose"], reading.notes)))
    more, scene = read_constraints(document["constraints"], scene, reading)
    reduced = reduce_model(scene, group.name, near)
    found = inverse_kinematics(reduced, [*wanted, *more])
    if not found.free:
        return msg.GetPositionIKResponse(
            error_code=failed(msg.MoveItErrorCodes.NO_IK_SOLUTION, found.explain())
        )
    solution = state_message(stated.scene, reduced.all_positions(found.free[0]))
    return msg.GetPositionIKResponse(solution, with_notes(success(), reading.notes))


compute_ik = service(msg.GetPositionIKRequest, msg.GetPositionIKResponse, _searched)


def _known(link: str, scene: Scene) -> str:
    carried: Sequence[str] = [name for name in scene.objects if scene.holder(name).link in scene.robot.links]
    known = (*scene.frame_names, *carried)
    if link not in known:
        raise FrameNotFound("link", link, known)
    return link


def check_state_validity(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Check a state: contacts, constraints and, unlike MoveIt, joint limits."""
    request = read_call(msg.GetStateValidityRequest, arguments, watch)
    message, robot = request.message, state.scene.robot
    if message.group_name and message.group_name not in robot.groups:
        raise GroupNotFound("group", message.group_name, robot.groups)
    stated = stated_in(message.robot_state, state, "robot_state")
    document = document_of(message.constraints, "constraints")
    constraints, scene = read_constraints(document, stated.scene, stated.reading)
    groups = [message.group_name] if message.group_name else robot.groups
    reduced = (reduce_model(scene, group, stated.positions) for group in groups)
    judged = [validity(each, each.start_positions, requirements=constraints) for each in reduced]
    contacts = {
        frozenset((pair.first, pair.second)): msg.ContactInformation(
            header=msg.Header(frame_id=robot.links[0]),
            depth=max(-pair.distance, 0.0),
            contact_body_1=pair.first,
            body_type_1=_kind(pair.first, scene),
            contact_body_2=pair.second,
            body_type_2=_kind(pair.second, scene),
        )
        for each in judged
        for pair in each.examination.collisions
    }
    results = [
        msg.ConstraintEvalResult(check.holds, max(-(check.slack or 0.0), 0.0)) for check in judged[0].checks
    ]
    valid = all(each.valid for each in judged)
    return request.answer(msg.GetStateValidityResponse(valid, list(contacts.values()), [], results))


def _kind(name: str, scene: Scene) -> int:
    if name not in scene.objects:
        return msg.ContactInformation.ROBOT_LINK
    carried = scene.holder(name).link in scene.robot.links
    return msg.ContactInformation.ROBOT_ATTACHED if carried else msg.ContactInformation.WORLD_OBJECT


ALL = 2**32 - 1
NUMBERS = {msg.PointField.FLOAT32: "f4", msg.PointField.FLOAT64: "f8"}
OF_SENSORS = "cloud"
"""Prefix of the names of point cloud objects, followed by the sensor's frame."""


def get_planning_scene(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Return the requested components of the scene."""
    request = read_call(msg.GetPlanningSceneRequest, arguments, watch)
    components = request.message.components.components or ALL
    return request.answer(
        msg.GetPlanningSceneResponse(scene_message(state.scene, state.positions, components))
    )


def apply_planning_scene(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Replace the scene, or apply a difference; the robot takes the message's positions."""
    request = read_call(msg.ApplyPlanningSceneRequest, arguments, watch)
    message = request.message.scene
    positions = positions_in(message.robot_state, state, "scene.robot_state")
    document = document_of(message, "scene")
    scene = edit_scene(document, state.scene, reading_at(state.scene, positions))
    changed = replace(state, scene=scene, positions=positions)
    return request.answer(msg.ApplyPlanningSceneResponse(success=True), changed)


def edit_collision_object(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Apply a collision object message from a topic."""
    request = read_call(msg.CollisionObject, arguments, watch)
    document = document_of(request.message, "collision object")
    scene = edit_object(document, state.scene, reading_at(state.scene, state.positions))
    return Answer({}, replace(state, scene=scene))


def edit_attached_object(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Apply an attached collision object message from a topic."""
    request = read_call(msg.AttachedCollisionObject, arguments, watch)
    document = document_of(request.message, "attached object")
    scene = apply_attached(document, state.scene, reading_at(state.scene, state.positions))
    return Answer({}, replace(state, scene=scene))


def point_cloud(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Replace the last point cloud of a sensor in the scene, without points on the robot.

    The object's name contains the sensor's frame. A message older than the newest is ignored; stamp 0 means
    no stamp.
    """
    message = read_call(msg.PointCloud2, arguments, watch).message
    if message.width * message.height > watch.cloud:
        raise RequestRefused(
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


def points_of(message: msg.PointCloud2) -> Floats:
    """Return the points of a message, shape (n, 3) [m]; unmeasured points are not finite."""
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
