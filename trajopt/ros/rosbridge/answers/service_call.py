"""Requests of clients made for ROS, and MoveIt's error codes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from trajopt.files.messages import Generation, MoveItErrorCodes, decode, document_of, encode
from trajopt.files.moveit.frames import Reading, reading_at
from trajopt.files.moveit.objects import apply_attached
from trajopt.files.moveit.scene_messages import layered_positions, read_joint_positions
from trajopt.scene.scene import Scene
from trajopt.server.limits import check_sizes
from trajopt.server.operation import Answer, SessionState, Watch
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node
from trajopt.values.errors import FrameNotFound, GroupNotFound, NameNotFound, ObjectNotFound, TrajoptError

SOURCE = "trajopt"
BY_PART = {
    "goal_constraints": MoveItErrorCodes.INVALID_GOAL_CONSTRAINTS,
    "path_constraints": MoveItErrorCodes.INVALID_GOAL_CONSTRAINTS,
    "trajectory_constraints": MoveItErrorCodes.INVALID_GOAL_CONSTRAINTS,
    "start_state": MoveItErrorCodes.INVALID_ROBOT_STATE,
    "robot_state": MoveItErrorCodes.INVALID_ROBOT_STATE,
}
"""Error code of a fault in each part of a request; MoveIt has one code for all constraints."""


def success(message: str = "") -> MoveItErrorCodes:
    return MoveItErrorCodes(MoveItErrorCodes.SUCCESS, message, SOURCE)


def with_notes(code: MoveItErrorCodes, notes: Sequence[str]) -> MoveItErrorCodes:
    return replace(code, message="; ".join(each for each in (code.message, *notes) if each))


def failed(code: int, reason: str) -> MoveItErrorCodes:
    return MoveItErrorCodes(code, reason, SOURCE)


def code_of_error(error: TrajoptError) -> MoveItErrorCodes:
    """Return the error code of a request with an unknown name, or a malformed one."""
    return failed(_code(error), str(error))


def _code(error: TrajoptError) -> int:
    if isinstance(error, GroupNotFound):
        return MoveItErrorCodes.INVALID_GROUP_NAME
    if isinstance(error, ObjectNotFound):
        return MoveItErrorCodes.INVALID_OBJECT_NAME
    if isinstance(error, FrameNotFound):
        header = "header" in error.kind
        return MoveItErrorCodes.FRAME_TRANSFORM_FAILURE if header else MoveItErrorCodes.INVALID_LINK_NAME
    where = error.kind if isinstance(error, NameNotFound) else str(error)
    return next((code for part, code in BY_PART.items() if part in where), MoveItErrorCodes.FAILURE)


@dataclass(frozen=True)
class ServiceCall:
    """A request."""

    message: Any
    generation: Generation

    def answer(self, response: object, state: SessionState | None = None) -> Answer:
        return Answer(encode(response, self.generation), state)


def read_call(kind: type[Any], arguments: Node, watch: Watch) -> ServiceCall:
    generation = Generation[arguments["ros"].text()]
    check_sizes(arguments["args"].value, watch)
    message = decode(kind, arguments["args"].value, generation, name="args")
    return ServiceCall(message, generation)


def service(
    kind: type[Any], response: type[Any], answer: Callable[[Any, SessionState, Watch], object]
) -> Callable[[SessionState, Node, Watch], Answer]:
    """Return the operation of a service whose response contains an error code."""

    def run(state: SessionState, arguments: Node, watch: Watch) -> Answer:
        request = read_call(kind, arguments, watch)
        try:
            return request.answer(answer(request.message, state, watch))
        except TrajoptError as error:
            return request.answer(response(error_code=code_of_error(error)))

    return run


@dataclass(frozen=True)
class RobotStated:
    """Content of a robot state message, added to the session's state."""

    scene: Scene
    positions: Floats
    reading: Reading


def stated_in(message: object, state: SessionState, place: str) -> RobotStated:
    """Read a robot state message: joints, a moving base, and attached objects.

    Objects attached in the session stay attached unless the message detaches them.
    """
    notes, robot, document = list[str](), state.scene.robot, document_of(message, place)
    stated = read_joint_positions(document, robot, notes)
    positions = layered_positions(robot, state.named_positions, stated)
    reading, scene = reading_at(state.scene, positions, notes), state.scene
    for element in document["attached_collision_objects"].elements():
        scene = apply_attached(element, scene, reading)
    return RobotStated(scene, positions, reading)


def positions_in(message: object, state: SessionState, place: str) -> Floats:
    """Return the positions of all joints in a robot state message; missing joints keep theirs.

    Joints that the robot does not have are ignored, as in MoveIt.
    """
    robot = state.scene.robot
    stated = read_joint_positions(document_of(message, place), robot, [])
    return layered_positions(robot, state.named_positions, stated)
