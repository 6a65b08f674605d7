"""Robot states: `/compute_fk`, `/compute_ik` and `/check_state_validity`."""

from collections.abc import Sequence

from trajopt.files.messages import (
    ConstraintEvalResult,
    ContactInformation,
    GetPositionFKRequest,
    GetPositionFKResponse,
    GetPositionIKRequest,
    GetPositionIKResponse,
    GetStateValidityRequest,
    GetStateValidityResponse,
    Header,
    MoveItErrorCodes,
    PoseStamped,
    PositionIKRequest,
    document_of,
)
from trajopt.files.moveit.constraints import read_constraints
from trajopt.files.moveit.frames import placement_in_world, read_frame
from trajopt.files.moveit.planning_scene import without_collisions
from trajopt.files.moveit.pose import pose_of, read_placement
from trajopt.files.moveit.scene_messages import state_message
from trajopt.optimise.kinematics import Validity, inverse_kinematics, validity
from trajopt.problem.requirements import Requirement, frame_placement
from trajopt.ros.rosbridge.answers.service_call import (
    code_of_error,
    failed,
    read_call,
    stated_in,
    success,
    with_notes,
)
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.server.operation import Answer
from trajopt.server.state import SessionState
from trajopt.server.watch import Watch
from trajopt.values.documents.document import Node
from trajopt.values.errors import FrameNotFound, GroupNotFound, TrajoptError


def compute_fk(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Return the poses of links in a state, in the frame of the request's header."""
    request = read_call(GetPositionFKRequest, arguments, watch)
    try:
        response = _placed(request.message, state)
    except TrajoptError as error:
        response = GetPositionFKResponse(error_code=code_of_error(error))
    return request.answer(response)


def _placed(request: GetPositionFKRequest, state: SessionState) -> GetPositionFKResponse:
    stated, names = stated_in(request.robot_state, state, "robot_state"), request.fk_link_names
    scene, reading = stated.scene, stated.reading
    if not names:
        return GetPositionFKResponse(
            error_code=failed(MoveItErrorCodes.INVALID_LINK_NAME, "fk_link_names names no link")
        )
    known = (*scene.frame_names, *scene.objects)
    for name in names:
        if name not in known:
            raise FrameNotFound("link", name, known)
    frame = read_frame(document_of(request, "args")["header"], scene, reading)
    back = placement_in_world(frame, scene, reading).inverse()
    header = Header(frame_id=request.header.frame_id or scene.robot.links[0])
    poses = [PoseStamped(header, pose_of(back * placement_in_world(name, scene, reading))) for name in names]
    return GetPositionFKResponse(poses, list(names), with_notes(success(), reading.notes))


def compute_ik(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Return the state nearest to a given one with links at given poses."""
    request = read_call(GetPositionIKRequest, arguments, watch)
    try:
        response = _searched(request.message.ik_request, state)
    except TrajoptError as error:
        response = GetPositionIKResponse(error_code=code_of_error(error))
    return request.answer(response)


def _searched(request: PositionIKRequest, state: SessionState) -> GetPositionIKResponse:
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
        wanted.append(frame_placement(name, frame * read_placement(pose["pose"], reading.notes)))
    more, scene = read_constraints(document["constraints"], scene, reading)
    found = inverse_kinematics(reduce_model(scene, group.name, near), [*wanted, *more])
    if not found.free:
        return GetPositionIKResponse(error_code=failed(MoveItErrorCodes.NO_IK_SOLUTION, found.explain()))
    reduced = reduce_model(scene, group.name, near)
    solution = state_message(stated.scene, reduced.all_positions(found.free[0]))
    return GetPositionIKResponse(solution, with_notes(success(), reading.notes))


def _known(link: str, scene: Scene) -> str:
    carried: Sequence[str] = [name for name in scene.objects if scene.holder(name).link in scene.robot.links]
    known = (*scene.frame_names, *carried)
    if link not in known:
        raise FrameNotFound("link", link, known)
    return link


def check_state_validity(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Check a state: contacts, constraints and, unlike MoveIt, joint limits.

    Without a group, all groups are checked.

    Raises:
        NameNotFound: If a name is unknown; the service has no error code for it.
    """
    request = read_call(GetStateValidityRequest, arguments, watch)
    message, robot = request.message, state.scene.robot
    if message.group_name and message.group_name not in robot.groups:
        raise GroupNotFound("group", message.group_name, robot.groups)
    stated = stated_in(message.robot_state, state, "robot_state")
    positions, document = stated.positions, document_of(message.constraints, "constraints")
    constraints, scene = read_constraints(document, stated.scene, stated.reading)
    judged: list[Validity] = []
    for group in [message.group_name] if message.group_name else robot.groups:
        reduced = reduce_model(scene, group, positions)
        here = positions[robot.index(reduced.joint_names)]
        judged.append(validity(reduced, here, requirements=constraints))
    contacts = {
        frozenset((pair.first, pair.second)): ContactInformation(
            header=Header(frame_id=robot.links[0]),
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
        ConstraintEvalResult(check.holds, max(-(check.slack or 0.0), 0.0)) for check in judged[0].checks
    ]
    valid = all(each.valid for each in judged)
    return request.answer(GetStateValidityResponse(valid, list(contacts.values()), [], results))


def _kind(name: str, scene: Scene) -> int:
    """Return MoveIt's number of a body's type."""
    if name not in scene.objects:
        return ContactInformation.ROBOT_LINK
    carried = scene.holder(name).link in scene.robot.links
    return ContactInformation.ROBOT_ATTACHED if carried else ContactInformation.WORLD_OBJECT
