"""Trajectories as messages, which MoveIt sends for execution."""

from trajopt.files.messages import decode
from trajopt.files.messages.builtin_interfaces import Duration
from trajopt.files.messages.moveit_msgs import RobotTrajectory
from trajopt.files.messages.std_msgs import Header
from trajopt.files.messages.trajectory_msgs import (
    JointTrajectory,
    JointTrajectoryPoint,
    MultiDOFJointTrajectory,
    MultiDOFJointTrajectoryPoint,
)
from trajopt.files.moveit.joint_trajectory import on_whole_nanoseconds
from trajopt.files.moveit.planar_joints import multi_dof_points, planar_joints, split
from trajopt.values.trajectory import Trajectory


def trajectory_message(trajectory: Trajectory | None, frame: str = "") -> RobotTrajectory:
    """Return a trajectory as a message with points at whole nanoseconds; for None an empty message.

    Raises:
        ShapeError: If two points are less than a nanosecond apart.
    """
    if trajectory is None:
        return RobotTrajectory()
    single, several = split(on_whole_nanoseconds(trajectory))
    message = RobotTrajectory()
    if single is not None:
        names = list(single.joint_names)
        message.joint_trajectory = JointTrajectory(Header(frame_id=frame), names, _points(single))
    if several is not None:
        message.multi_dof_joint_trajectory = MultiDOFJointTrajectory(
            Header(frame_id=frame), list(planar_joints(several.joint_names)), _transforms(several)
        )
    return message


def _points(trajectory: Trajectory) -> list[JointTrajectoryPoint]:
    return [
        JointTrajectoryPoint(
            trajectory.positions[place].tolist(),
            [] if trajectory.velocities is None else trajectory.velocities[place].tolist(),
            [] if trajectory.accelerations is None else trajectory.accelerations[place].tolist(),
            time_from_start=Duration(moment),
        )
        for place, moment in enumerate(trajectory.times.tolist())
    ]


def _transforms(trajectory: Trajectory) -> list[MultiDOFJointTrajectoryPoint]:
    points: list[MultiDOFJointTrajectoryPoint] = []
    for document, moment in zip(multi_dof_points(trajectory), trajectory.times.tolist(), strict=True):
        stated = {key: value for key, value in document.items() if key != "time_from_start"}
        point = decode(MultiDOFJointTrajectoryPoint, stated)
        point.time_from_start = Duration(moment)
        points.append(point)
    return points
