"""Trajectory messages as trajectories and back, and the timing of their paths."""

from trajopt.commander.documents import document_of, is_message
from trajopt.commander.exception import MoveItCommanderException
from trajopt.commander.moveit_msgs.msg import RobotTrajectory
from trajopt.commander.rospy import Duration
from trajopt.commander.std_msgs.msg import Header
from trajopt.commander.trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from trajopt.methods.timing import retime_path
from trajopt.model.reduced import ReducedModel
from trajopt.model.requirements import joint_positions
from trajopt.model.trajectory import Path, Trajectory
from trajopt.moveit.robot_trajectory import read_joint_trajectory
from trajopt.problem import Problem
from trajopt.retime import RetimeFailure

ALGORITHMS = (
    "iterative_time_parameterization",
    "iterative_spline_parameterization",
    "time_optimal_trajectory_generation",
)
"""Names that MoveIt has for algorithms of this kind."""
PATH_TOLERANCE = 1e-3
"""How far the timed motion may leave the path [m]; MoveIt's leaves it by 0.1 rad in every joint."""


def retimed(
    reduced: ReducedModel, trajectory: Trajectory, *, velocity: float, acceleration: float
) -> Trajectory:
    """Return the fastest motion along the points of a trajectory within all limits.

    Args:
        reduced: The robot in its scene, the group's joints free.
        trajectory: Joints in the group's order; its times do not count.
        velocity: Factor in (0, 1] on the velocity limits.
        acceleration: Factor in (0, 1] on the acceleration limits.

    Raises:
        MoveItCommanderException: If no timing holds the limits.
        ProblemError: If a factor is outside (0, 1].
    """
    last = dict(zip(reduced.joint_names, trajectory.positions[-1].tolist(), strict=True))
    problem = Problem(
        scene=reduced.scene,
        group=reduced.group,
        start=reduced.start,
        goal=joint_positions(last),
        velocity_scaling=velocity,
        acceleration_scaling=acceleration,
    )
    path = Path(reduced.joint_names, trajectory.positions)
    motion = retime_path(problem, path, tolerance=PATH_TOLERANCE)
    if isinstance(motion, RetimeFailure):
        raise MoveItCommanderException(f"retime_trajectory: {motion.reason}")
    return motion.trajectory


def trajectory_message(trajectory: Trajectory | None, frame: str = "") -> RobotTrajectory:
    """Return a trajectory as a message, times to the nanosecond; an empty one for none."""
    if trajectory is None:
        return RobotTrajectory()
    points = [
        JointTrajectoryPoint(
            trajectory.positions[place].tolist(),
            [] if trajectory.velocities is None else trajectory.velocities[place].tolist(),
            [] if trajectory.accelerations is None else trajectory.accelerations[place].tolist(),
            time_from_start=Duration(moment),
        )
        for place, moment in enumerate(trajectory.times.tolist())
    ]
    return RobotTrajectory(JointTrajectory(Header(frame_id=frame), list(trajectory.joint_names), points))


def trajectory_of(message: object, name: str) -> Trajectory | None:
    """Return the trajectory of a RobotTrajectory or JointTrajectory message; None where it has no points.

    Args:
        message: The message.
        name: What complaints call it.

    Raises:
        FileFormatError: If it is malformed.
    """
    whole = message if is_message(message, "joint_trajectory") else RobotTrajectory(message)  # pyright: ignore[reportArgumentType]
    document = document_of(whole, name)
    if not document["joint_trajectory"]["points"].elements():
        return None
    return read_joint_trajectory(document)
