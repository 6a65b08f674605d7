"""The subject of a request: the session's scene with the request's edits, and the problem."""

from dataclasses import replace

from trajopt.files.moveit.motion_plan_request import RequestFile, request_of
from trajopt.files.moveit.trajectories import read_joint_trajectory, read_points
from trajopt.problem.problem import Problem
from trajopt.problem.stated import only_group
from trajopt.robot.configuration import stated_configuration
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.server.operations.edits import edited
from trajopt.server.operations.words import called, value_of
from trajopt.server.state import SessionState
from trajopt.values.documents.document import Node
from trajopt.values.trajectory import Trajectory

ABOUT = ("edits", "problem", "request")
"""Members that state the problem."""


def changed(state: SessionState, arguments: Node) -> SessionState:
    """Return the session's content with the edits of a request, which apply to this request only."""
    return edited(state, arguments["edits"])


def request_in(state: SessionState, node: Node) -> RequestFile:
    """Return a `moveit_msgs/MotionPlanRequest` as a problem in a session's scene."""
    return request_of(node, state.scene, state.named_positions)


def problem_in(state: SessionState, arguments: Node) -> tuple[Problem, tuple[str, ...]]:
    """Return the problem of a request, and notes on its interpretation.

    It is stated by `problem`, in the words of the Python API, or by `request`, MoveIt's message.

    Raises:
        FileFormatError: If there is neither, or both, or it is invalid.
        TrajoptError: If it is not a valid problem.
    """
    state = changed(state, arguments)
    stated = [key for key in ("problem", "request") if arguments.has(key)]
    if len(stated) != 1:
        raise arguments.error("state the problem once: as `problem`, or as `request` (MoveIt's message)")
    if stated == ["request"]:
        read = request_in(state, arguments["request"])
        return read.problem(), read.notes
    node = arguments["problem"]
    if node.has("costs") or node.has("scene"):
        raise node.error("the scene is the session's, and costs are not for requests")
    return called(Problem, node, scene=state.scene, start=state.positions), ()


def reduced_in(state: SessionState, arguments: Node) -> ReducedModel:
    """Return the robot in a session's scene, with only the joints of the group that a request names free."""
    state = changed(state, arguments)
    group = arguments["group"].text("") or only_group(state.scene.robot)
    start = state.positions
    if arguments.has("start"):
        start = stated_configuration(state.scene.robot, "start", value_of(arguments["start"]), group=group)
    return reduce_model(state.scene, group, start)


def trajectory_in(node: Node) -> Trajectory:
    """Return a trajectory: joint names and points, or MoveIt's `RobotTrajectory`.

    Raises:
        FileFormatError: If it is neither.
    """
    if node.missing:
        raise node.error("is missing")
    return read_joint_trajectory(node) if node.has("joint_trajectory") else read_points(node)


def at_start(state: SessionState, problem: Problem) -> SessionState:
    """Return the session's content with the robot at the start of a problem."""
    return replace(state, scene=problem.scene, positions=problem.start_positions)
