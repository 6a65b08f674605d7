"""Trajectories and plans from files of every format."""

from pathlib import Path

from trajopt.files.moveit.joint_trajectory import read_points
from trajopt.files.moveit.robot_trajectory import read_joint_trajectory
from trajopt.files.moveit.trajectory_table import read_table
from trajopt.values.documents.document import Node, read_document
from trajopt.values.documents.files import read_bytes
from trajopt.values.errors import FileFormatError
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory

GOAL_FIELDS = (
    *("trajectory", "multi_dof_trajectory", "path_tolerance", "component_path_tolerance"),
    *("goal_tolerance", "component_goal_tolerance", "goal_time_tolerance"),
)
"""Members of a goal of `control_msgs/action/FollowJointTrajectory`."""
FORMATS = (
    "a plan's JSON, a RobotTrajectory, JointTrajectory or FollowJointTrajectory goal in JSON or YAML, "
    "or trajopt's CSV"
)
"""The formats of `read_trajectory`, for help texts."""


@checked
def read_trajectory(path: Path | str) -> Trajectory:
    """Read a trajectory in any format that trajopt writes, except URScript.

    The file may be a plan's JSON, a `moveit_msgs/RobotTrajectory`, a `trajectory_msgs/JointTrajectory`, or
    the goal of a `control_msgs/action/FollowJointTrajectory` (each JSON if the file name ends in .json, else
    YAML). A name that ends in .csv means a table with columns `time`, `position_JOINT`, `velocity_JOINT` and
    `acceleration_JOINT`. Points are interpolated by quintic polynomials with accelerations, by cubic ones
    with velocities, else linearly. Tolerances of a goal are ignored.

    Raises:
        FileFormatError: If the file is incomplete or malformed.
    """
    if Path(path).suffix.lower() == ".csv":
        return read_table(path)
    document = _document(path)
    if document.has("status") and not document["points"].elements():
        raise document.error(f"holds no motion: {document['message'].text('')}")
    if document.has("trajectory"):
        document.only(GOAL_FIELDS)
        if document["multi_dof_trajectory"]["points"].elements():
            raise document["multi_dof_trajectory"].error("cannot be read; a RobotTrajectory with it can")
        document = document["trajectory"]
    if document.has("joint_trajectory") or document.has("multi_dof_joint_trajectory"):
        return read_joint_trajectory(document)
    if not document.has("joint_names"):
        raise document.error(f"holds no trajectory (joint_names and points); readable formats: {FORMATS}")
    return read_points(document)


def _document(path: Path | str) -> Node:
    try:
        return read_document(path)
    except FileFormatError as error:
        if any(word in read_bytes(Path(path)) for word in (b"servoj(", b"movej(")):
            reason = f"is a program in URScript, which is not read back; readable formats: {FORMATS}"
            raise FileFormatError(str(path), reason) from error
        raise
