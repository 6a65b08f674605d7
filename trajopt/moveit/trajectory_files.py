"""Trajectories and plans on disk."""

import json
from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import cast

from trajopt.errors import FileFormatError, shown
from trajopt.errors.arguments import checked
from trajopt.io.document import read_document, write_text
from trajopt.model.trajectory import Trajectory
from trajopt.moveit.joint_trajectory import read_points
from trajopt.moveit.robot_trajectory import read_joint_trajectory
from trajopt.moveit.trajectory_table import read_table

GOAL_FIELDS = (
    *("trajectory", "multi_dof_trajectory", "path_tolerance", "component_path_tolerance"),
    *("goal_tolerance", "component_goal_tolerance", "goal_time_tolerance"),
)
"""Members of a goal of `control_msgs/action/FollowJointTrajectory`."""
FORMATS = (
    "a plan's JSON, a RobotTrajectory, JointTrajectory or FollowJointTrajectory goal in JSON or YAML, "
    "or trajopt's CSV"
)
"""What `read_trajectory` reads, for the help of what calls it."""


@checked
def read_trajectory(path: Path | str) -> Trajectory:
    """Read a trajectory: whatever trajopt writes, but for URScript.

    The file may be a plan's JSON, a `moveit_msgs/RobotTrajectory`, a `trajectory_msgs/JointTrajectory`, the
    goal of a `control_msgs/action/FollowJointTrajectory` (each JSON where the file's name ends so, YAML
    otherwise), or, where the name ends in .csv, a table with columns `time`, `position_JOINT`,
    `velocity_JOINT` and `acceleration_JOINT`. It is taken as written: quintic between points with
    accelerations, cubic with velocities, else linear. Tolerances of a goal are not looked at.

    Raises:
        FileFormatError: If the file does not say what it must.
    """
    if Path(path).suffix.lower() == ".csv":
        return read_table(path)
    document = read_document(path)
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
        raise document.error(f"holds no trajectory (joint_names and points); what can be read: {FORMATS}")
    return read_points(document)


def write_json(path: Path | str, document: Mapping[str, object]) -> None:
    """Write a document as JSON, in one step; numbers are written exactly.

    Raises:
        FileFormatError: If it holds what JSON cannot say (such as nan), or cannot be written.
    """
    _check(document, str(path), "")
    write_text(path, json.dumps(document, indent=1, allow_nan=False) + "\n")


def _check(value: object, path: str, place: str) -> None:
    match value:
        case dict():
            for key, inner in cast("dict[object, object]", value).items():
                if not isinstance(key, str):
                    raise FileFormatError(path, f"{place}: the key {shown(key)} is no text")
                _check(inner, path, f"{place}.{key}" if place else key)
        case list() | tuple():
            for i, inner in enumerate(cast("Sequence[object]", value)):
                _check(inner, path, f"{place}[{i}]")
        case float() if not isfinite(value):
            raise FileFormatError(path, f"{place}: {value} is no number that JSON can hold")
        case None | bool() | int() | float() | str():
            pass
        case _:
            raise FileFormatError(path, f"{place}: JSON cannot hold a {type(value).__name__}")
