"""Trajectory messages as trajectories and back, and the timing of their paths."""

from collections.abc import Mapping

from trajopt.files.messages import document_of, is_message
from trajopt.files.moveit.planar_joints import turned_from
from trajopt.files.moveit.robot_trajectory import read_joint_trajectory
from trajopt.optimise.methods.timing import retime_path
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import joint_positions
from trajopt.robot.loading.groups import Group
from trajopt.ros.commander.moveit_msgs.msg import RobotTrajectory
from trajopt.scene.reduced import ReducedModel
from trajopt.server.move_group.outcome import MoveItCommanderException
from trajopt.timing import RetimeFailure
from trajopt.values.trajectory import Path, Trajectory

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


def trajectory_of(message: object, name: str, group: Group, start: Mapping[str, float]) -> Trajectory | None:
    """Return the trajectory of a RobotTrajectory or JointTrajectory message; None where it has no points.

    Args:
        message: The message.
        name: What complaints call it.
        group: Whose joints it is of.
        start: Joint -> where it is [rad | m]: a base's whole turns, which no message tells, are those from
            there.

    Raises:
        FileFormatError: If it is malformed.
        JointNotFound: If a joint of the group is missing.
        ShapeError: If it moves other joints.
    """
    whole = message if is_message(message, "joint_trajectory") else RobotTrajectory(message)  # pyright: ignore[reportArgumentType]
    document = document_of(whole, name)
    lists = ("joint_trajectory", "multi_dof_joint_trajectory")
    if not any(document[each]["points"].elements() for each in lists):
        return None
    return turned_from(start, read_joint_trajectory(document)).ordered(group.joints)
