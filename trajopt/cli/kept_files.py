"""Files of MoveIt's, read so that a warehouse can keep what they say."""

from dataclasses import dataclass
from pathlib import Path

from trajopt.cli.options import RobotSource
from trajopt.files.moveit import read_request, read_scene
from trajopt.files.moveit.constraints import read_constraints
from trajopt.files.moveit.frames import Reading, world_names
from trajopt.files.moveit.robot_state import checked_joint_positions, layered_positions
from trajopt.problem.problem import Problem
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.server.warehouse import Constraints, State
from trajopt.values.documents.document import read_document
from trajopt.values.errors import FileFormatError, ModelError


@dataclass(frozen=True)
class Given:
    """What was named on the command line.

    Attributes:
        robot: The robot: installed, or a description's file.
        srdf: With a description: its SRDF.
        packages: With a description: where `package://` meshes are.
        scene: MoveIt's PlanningScene.
        request: MoveIt's MotionPlanRequest.
        state: MoveIt's RobotState.
        constraints: MoveIt's Constraints.
    """

    robot: str | None
    srdf: Path | None = None
    packages: tuple[Path, ...] = ()
    scene: Path | None = None
    request: Path | None = None
    state: Path | None = None
    constraints: Path | None = None


def value_given(given: Given) -> Robot | Scene | Problem | State | Constraints:
    """Return what is to be kept.

    Raises:
        ModelError: If nothing is named, or too much.
        FileFormatError: If a file does not say what it must.
    """
    if given.robot is None:
        raise ModelError("give what is to be kept: --bundle, or --robot with or without what is of it")
    chosen = [each for each in (given.scene, given.state, given.constraints) if each is not None]
    if len(chosen) > 1 or (given.request is not None and given.scene is None):
        raise ModelError("give one of --scene (with or without --request), --state and --constraints")
    robot = RobotSource(given.robot, given.srdf, None, given.packages).load()
    if given.scene is not None:
        around = read_scene(given.scene, robot)
        return around.scene if given.request is None else read_request(given.request, around).problem()
    if given.state is not None:
        return State(robot.name, checked_joint_positions(read_document(given.state), robot))
    return robot if given.constraints is None else _constraints(given.constraints, robot)


def _constraints(path: Path, robot: Robot) -> Constraints:
    """Return the requirements of a constraints message.

    Raises:
        FileFormatError: If it requires nothing, or something in a frame that it makes itself.
    """
    scene = Scene(robot)
    reading = Reading(world_names(robot), layered_positions(robot))
    required, around = read_constraints(read_document(path), scene, reading)
    if not required:
        raise FileFormatError(str(path), "requires nothing")
    if around is not scene:
        raise FileFormatError(str(path), "needs a frame of its own: keep it as part of a problem")
    return Constraints(robot.name, required)
