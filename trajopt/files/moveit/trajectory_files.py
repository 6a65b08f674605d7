"""Trajectories from files of every format: messages, plans, and tables in CSV."""

import csv
import io
from collections.abc import Sequence
from itertools import pairwise
from math import isfinite
from pathlib import Path

import numpy as np

from trajopt.files.messages import FollowJointTrajectoryGoal, field_names
from trajopt.files.moveit.trajectories import read_joint_trajectory, read_points
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node, read_document
from trajopt.values.documents.files import read_bytes, read_text
from trajopt.values.errors import FileFormatError, listed, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory

ORDERS = ("position", "velocity", "acceleration")
"""Prefixes of column names, before `_` and the joint's name."""
FORMATS = (
    "a plan's JSON, a RobotTrajectory, JointTrajectory or FollowJointTrajectory goal in JSON or YAML, "
    "or trajopt's CSV"
)
"""The formats of `read_trajectory`, for help texts."""


def read_table(path: Path | str) -> Trajectory:
    """Read a table: `time` [s], and `position_NAME`, `velocity_NAME` and `acceleration_NAME` of each joint.

    Columns may have any order; the joints follow the order of the position columns. Accelerations, or
    velocities and accelerations, may be omitted for all joints. Rows are interpolated by quintic polynomials
    with both, by cubic ones with velocities, else linearly.

    Raises:
        FileFormatError: If columns are missing, unknown or duplicate, a number is malformed, or time does not
            increase from 0.
    """
    try:
        lines = [line for line in csv.reader(io.StringIO(read_text(path)), strict=True) if line]
    except csv.Error as error:
        raise FileFormatError(str(path), f"is not a table: {error}") from error
    if len(lines) < 3:
        raise FileFormatError(str(path), "a table has a line of column names and two rows at least")
    columns = [name.strip() for name in lines[0]]
    names = _joints(path, columns)
    table = _numbers(path, columns, lines[1:])
    times = table[:, columns.index("time")]
    _check_times(path, times)
    rows = [
        table[:, [columns.index(f"{order}_{name}") for name in names]]
        if f"{order}_{names[0]}" in columns
        else None
        for order in ORDERS
    ]
    assert rows[0] is not None
    return Trajectory(names, times, rows[0], rows[1], rows[2])


def _joints(path: Path | str, columns: Sequence[str]) -> tuple[str, ...]:
    """Return the joint names, after checking that every column occurs once and none is unknown."""
    names = tuple(name.removeprefix("position_") for name in columns if name.startswith("position_"))
    if "time" not in columns or not all(names) or not names:
        raise FileFormatError(
            str(path), "the first line must name the columns: time, position_JOINT, ... for each joint"
        )
    has = [any(column.startswith(f"{order}_") for column in columns) for order in ORDERS]
    if has[2] and not has[1]:
        raise FileFormatError(str(path), "has accelerations, but no velocities")
    due = ["time"]
    due += [f"{order}_{name}" for order, there in zip(ORDERS, has, strict=True) if there for name in names]
    missing = [name for name in due if name not in columns]
    if missing:
        raise FileFormatError(str(path), f"has no column {listed(missing)}")
    for place, name in enumerate(columns):
        if name not in due:
            raise FileFormatError(str(path), f"unknown column {shown(name)}")
        if name in columns[:place]:
            raise FileFormatError(str(path), f"has the column {shown(name)} twice")
    return names


def _numbers(path: Path | str, columns: Sequence[str], lines: Sequence[Sequence[str]]) -> Floats:
    table = np.empty((len(lines), len(columns)))
    for row, line in enumerate(lines):
        if len(line) != len(columns):
            raise FileFormatError(str(path), f"row {row + 1}: {len(line)} numbers for {len(columns)} columns")
        for place, text in enumerate(line):
            try:
                table[row, place] = float(text)
            except ValueError:
                table[row, place] = np.nan
            if not isfinite(table[row, place]):
                where = f"row {row + 1}, {columns[place]}"
                raise FileFormatError(str(path), f"{where}: must be a finite number, is {shown(text)}")
    return table


def _check_times(path: Path | str, times: Floats) -> None:
    if times[0] != 0.0:
        raise FileFormatError(str(path), f"row 1, time: must be 0, is {times[0]:g} s")
    for row, (before, after) in enumerate(pairwise(times.tolist()), start=2):
        if after <= before:
            raise FileFormatError(str(path), f"row {row}, time: {after:g} s does not come after {before:g} s")


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
        document.only(field_names(FollowJointTrajectoryGoal))
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
