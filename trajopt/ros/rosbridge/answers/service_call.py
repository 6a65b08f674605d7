"""What a client made for ROS asks: a message in its ROS' way of writing, and where the robot stands by it."""

from dataclasses import dataclass
from typing import Generic, TypeVar

from trajopt.files.messages import Generation, decode, document_of, encode
from trajopt.files.moveit.attached_object import apply_attached
from trajopt.files.moveit.frames import Reading, world_names
from trajopt.files.moveit.robot_state import layered_positions, read_joint_positions
from trajopt.scene.scene import Scene
from trajopt.server.memory import check_sizes
from trajopt.server.operation import Answer
from trajopt.server.state import SessionState
from trajopt.server.watch import Watch
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node

M = TypeVar("M")


@dataclass(frozen=True)
class ServiceCall(Generic[M]):
    """A request.

    Attributes:
        message: What is asked.
        generation: How the client's ROS writes messages.
    """

    message: M
    generation: Generation

    def answer(self, response: object, state: SessionState | None = None) -> Answer:
        """Return a message as the answer.

        Args:
            response: The message.
            state: What the session holds from now on; None where it stays as it was.
        """
        return Answer(encode(response, self.generation), state)


def read_call(kind: type[M], arguments: Node, watch: Watch) -> ServiceCall[M]:
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


def reading_in(scene: Scene, positions: Floats) -> Reading:
    """Return what names and frames in a message mean while the robot stands at positions."""
    return Reading(world_names(scene.robot), positions)


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
    reading, scene = Reading(world_names(robot), positions, None, notes), state.scene
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
