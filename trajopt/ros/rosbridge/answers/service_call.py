"""Requests of clients made for ROS: the message, the robot state in it, and MoveIt's error codes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from trajopt.files.messages import Generation, MoveItErrorCodes, decode, document_of, encode
from trajopt.files.moveit.frames import Reading, reading_at
from trajopt.files.moveit.objects import apply_attached
from trajopt.files.moveit.robot_state import layered_positions, read_joint_positions
from trajopt.scene.scene import Scene
from trajopt.server.memory import check_sizes
from trajopt.server.operation import Answer
from trajopt.server.state import SessionState
from trajopt.server.watch import Watch
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node
from trajopt.values.errors import (
    FrameNotFound,
    GroupNotFound,
    NameNotFound,
    ObjectNotFound,
    TrajoptError,
)

SOURCE = "trajopt"
"""Who says so."""
BY_PART = {
    "goal_constraints": MoveItErrorCodes.INVALID_GOAL_CONSTRAINTS,
    "path_constraints": MoveItErrorCodes.INVALID_GOAL_CONSTRAINTS,
    "trajectory_constraints": MoveItErrorCodes.INVALID_GOAL_CONSTRAINTS,
    "start_state": MoveItErrorCodes.INVALID_ROBOT_STATE,
    "robot_state": MoveItErrorCodes.INVALID_ROBOT_STATE,
}
"""The code of what is wrong in a part of a request; MoveIt has one code for all constraints."""


def success(message: str = "") -> MoveItErrorCodes:
    """Return the code of what was done, with a remark."""
    return MoveItErrorCodes(MoveItErrorCodes.SUCCESS, message, SOURCE)


def with_notes(code: MoveItErrorCodes, notes: Sequence[str]) -> MoveItErrorCodes:
    """Return a code whose message says too what was taken differently from how it was asked, or left out."""
    return replace(code, message="; ".join(each for each in (code.message, *notes) if each))


def failed(code: int, reason: str) -> MoveItErrorCodes:
    """Return the code of what was not done, with the reason."""
    return MoveItErrorCodes(code, reason, SOURCE)


def code_of_error(error: TrajoptError) -> MoveItErrorCodes:
    """Return the code of a request that names what does not exist, or cannot be read.

    A group, a link, an object and a frame have codes of their own; other names, and what is malformed, have
    that of the part of the request.
    """
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
    """A request.

    Attributes:
        message: What is asked.
        generation: How the client's ROS writes messages.
    """

    message: Any
    generation: Generation

    def answer(self, response: object, state: SessionState | None = None) -> Answer:
        """Return a message as the answer.

        Args:
            response: The message.
            state: What the session holds from now on; None where it stays as it was.
        """
        return Answer(encode(response, self.generation), state)


def read_call(kind: type[Any], arguments: Node, watch: Watch) -> ServiceCall:
    """Return what is asked.

    Args:
        kind: Kind of the message.
        arguments: The name of the generation as `ros`, and the message as `args`.
        watch: Of the request: it knows how large meshes and trajectories may be.

    Raises:
        FileFormatError: If the message does not fit its kind.
        Refusal: If it is too large.
    """
    generation = Generation[arguments["ros"].text()]
    check_sizes(arguments["args"].value, watch)
    message = decode(kind, arguments["args"].value, generation, name="args")
    return ServiceCall(message, generation)


@dataclass(frozen=True)
class RobotStated:
    """What a robot state message says, on top of what the session holds.

    Attributes:
        scene: The scene, with what the message has the robot carry.
        positions: Where all joints are [rad | m].
        reading: What names and frames mean there.
    """

    scene: Scene
    positions: Floats
    reading: Reading


def stated_in(message: object, state: SessionState, place: str) -> RobotStated:
    """Return what a robot state message says: joints, a base that moves, and what links carry.

    What the session's robot carries it carries here too, unless the message takes it away.

    Args:
        message: The message.
        state: What the session holds.
        place: What complaints call the message.

    Raises:
        FileFormatError: If it is malformed.
        NameNotFound: If it names an unknown link or object.
    """
    notes, robot, document = list[str](), state.scene.robot, document_of(message, place)
    stated = read_joint_positions(document, robot, notes)
    positions = layered_positions(robot, state.named_positions, stated)
    reading, scene = reading_at(state.scene, positions, notes), state.scene
    for element in document["attached_collision_objects"].elements():
        scene = apply_attached(element, scene, reading)
    return RobotStated(scene, positions, reading)


def positions_in(message: object, state: SessionState, place: str) -> Floats:
    """Return positions of all joints in a robot state message; those it leaves out are where they are now.

    Args:
        message: The message; joints that the robot does not have are left out, as MoveIt does.
        state: What the session holds.
        place: What complaints call the message.

    Raises:
        FileFormatError: If it is malformed.
    """
    robot = state.scene.robot
    stated = read_joint_positions(document_of(message, place), robot, [])
    return layered_positions(robot, state.named_positions, stated)
