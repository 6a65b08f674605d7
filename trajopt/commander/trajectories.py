"""Robot trajectory messages and trajectories."""

from trajopt.commander.documents import document_of, is_message
from trajopt.commander.moveit_msgs.msg import RobotTrajectory
from trajopt.commander.rospy import Duration
from trajopt.commander.std_msgs.msg import Header
from trajopt.commander.trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from trajopt.model.trajectory import Trajectory
from trajopt.moveit.robot_trajectory import read_joint_trajectory


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
