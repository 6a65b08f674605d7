"""Trajectories and plans on disk, as JSON."""

import json
from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import cast

from trajopt.errors import FileFormatError, shown
from trajopt.io.document import read_document, write_text
from trajopt.model.trajectory import Trajectory
from trajopt.moveit.joint_trajectory import read_points
from trajopt.moveit.robot_trajectory import read_joint_trajectory


def read_trajectory(path: Path | str) -> Trajectory:
    """Read a trajectory from JSON or YAML.

    The file may be a plan that trajopt wrote, a bare mapping of `joint_names` and `points`
    (`trajectory_msgs/JointTrajectory`), or a `moveit_msgs/RobotTrajectory`. It is taken as
    written: quintic between points with accelerations, cubic with velocities, else linear.

    Raises:
        FileFormatError: If the file does not say what it must.
    """
    document = read_document(path)
    if document.has("joint_trajectory"):
        return read_joint_trajectory(document)
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
