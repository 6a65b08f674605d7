"""Whether a state is free: `/check_state_validity`."""

from trajopt.files.messages import document_of
from trajopt.files.messages.moveit_msgs import (
    ConstraintEvalResult,
    ContactInformation,
    GetStateValidityRequest,
    GetStateValidityResponse,
)
from trajopt.files.messages.std_msgs import Header
from trajopt.files.moveit.constraints import read_constraints
from trajopt.optimise.kinematics import Validity, validity
from trajopt.ros.rosbridge.answers.service_call import read_call, stated_in
from trajopt.scene.reduced import reduce_model
from trajopt.scene.scene import Scene
from trajopt.server.operation import Answer
from trajopt.server.state import SessionState
from trajopt.server.watch import Watch
from trajopt.values.documents.document import Node
from trajopt.values.errors import GroupNotFound


def check_state_validity(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Judge a state: contacts and constraints, and unlike in MoveIt joints beyond their limits.

    Without a group the joints of all groups are looked at.

    Raises:
        NameNotFound: If the request names what does not exist: the service has no error code to say so.
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
    """Return MoveIt's number of what a body is."""
    if name not in scene.objects:
        return ContactInformation.ROBOT_LINK
    carried = scene.holder(name).link in scene.robot.links
    return ContactInformation.ROBOT_ATTACHED if carried else ContactInformation.WORLD_OBJECT
