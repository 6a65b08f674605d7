"""Trajectories as messages, documents and files: JointTrajectory, RobotTrajectory and plain points."""

import csv
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from math import inf, isfinite
from pathlib import Path
from typing import cast

import numpy as np
import yaml

from trajopt.files import messages as msg
from trajopt.files.messages import document_of, encode, field_names, is_message
from trajopt.files.moveit.frames import read_placement, read_vector, transform_of
from trajopt.robot.bases import PLANAR
from trajopt.robot.loading.groups import Group
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node, read_document, write_text
from trajopt.values.documents.files import read_bytes, read_text
from trajopt.values.errors import FileFormatError, ShapeError, listed, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement, from_rpy, placement
from trajopt.values.trajectory import Trajectory

NANOSECONDS = 10**9
_DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
OFF_THE_PLANE = 1e-4
"""Largest deviation of a planar joint's transform from its plane: height or sine of the tilt [m | rad]."""
_TURN = 2.0 * np.pi


def write_message(path: Path | str, document: dict[str, object]) -> None:
    if Path(path).suffix == ".json":
        text = json.dumps(document, indent=1, allow_nan=False) + "\n"
    else:
        text = yaml.dump_all([document], Dumper=_DUMPER, sort_keys=False, default_flow_style=None, width=110)
    write_text(path, text)


def read_points(node: Node) -> Trajectory:
    """Return the trajectory of `joint_names` and `points`; other members are ignored.

    Interpolated as by `read_trajectory`; an empty list counts as absent.
    """
    names = tuple(name.text() for name in node["joint_names"].elements())
    if not names or len(set(names)) != len(names):
        raise node["joint_names"].error("must name every joint once")
    points = node["points"].elements()
    times = read_times(node["points"])
    positions = _read_rows(points, "positions", names)
    velocities = _read_rows(points, "velocities", names)
    accelerations = _read_rows(points, "accelerations", names)
    if positions is None:
        raise points[0].error("has no positions")
    if accelerations is not None and velocities is None:
        raise points[0].error("has accelerations, but no velocities")
    return Trajectory(names, times, positions, velocities, accelerations)


def read_times(node: Node) -> Floats:
    points = node.elements()
    if len(points) < 2:
        raise node.error(f"a trajectory has two points at least, not {len(points)}")
    times = [_read_time(point["time_from_start"]) for point in points]
    if times[0] != 0.0:
        raise points[0]["time_from_start"].error(f"must be 0 at the first point, is {times[0]:g} s")
    for point, (before, after) in zip(points[1:], pairwise(times), strict=True):
        if after <= before:
            raise point["time_from_start"].error(f"{after:g} s does not come after {before:g} s")
    return np.array(times)


def _read_time(node: Node) -> float:
    if not isinstance(node.value, dict):
        return node.number()
    node.only(("sec", "nanosec", "secs", "nsecs"))
    seconds = node["secs"] if node.has("secs") else node["sec"]
    rest = node["nsecs"] if node.has("nsecs") else node["nanosec"]
    time = (seconds.number(0.0) * NANOSECONDS + rest.number(0.0)) / NANOSECONDS
    if time == inf:
        raise node.error("must be finite")
    return time


def _read_rows(points: list[Node], key: str, names: tuple[str, ...]) -> Floats | None:
    rows = [point[key].numbers() for point in points]
    for point, row in zip(points, rows, strict=True):
        if bool(row) != bool(rows[0]):
            has, other = ("has", "has none") if row else ("has no", "has some")
            raise point.error(f"{has} {key}, but the first point {other}")
        if row and len(row) != len(names):
            raise point[key].error(f"{len(row)} numbers for {len(names)} joints")
    return np.array(rows) if rows[0] else None


def on_whole_nanoseconds(trajectory: Trajectory) -> Trajectory:
    """Return a motion with its points at whole nanoseconds, the resolution of messages.

    Each point is evaluated at its rounded time: original positions at rounded times could exceed the limits.
    """
    times = np.round(trajectory.times * NANOSECONDS) / NANOSECONDS
    if (np.diff(times) <= 0.0).any():
        raise ShapeError("times", "two points are less than a nanosecond apart")
    rounded = times != trajectory.times

    def at(order: int, given: Floats | None) -> Floats | None:
        return None if given is None else np.where(rounded[:, None], trajectory(times, order), given)

    positions = np.where(rounded[:, None], trajectory(times), trajectory.positions)
    rates = at(1, trajectory.velocities), at(2, trajectory.accelerations)
    return Trajectory(trajectory.joint_names, times, positions, *rates)


def planar_joints(joint_names: Sequence[str]) -> tuple[str, ...]:
    """Return the planar joints whose x, y and theta are all given, by MoveIt's variable names."""
    x, *others = PLANAR
    stems = (name.removesuffix(x) for name in joint_names if name.endswith(x))
    return tuple(stem for stem in stems if all(stem + suffix in joint_names for suffix in others))


def planar_placement(x: float, y: float, yaw: float) -> Placement:
    turned = from_rpy(0.0, 0.0, yaw)  # yaw may include full turns
    return placement((x, y, 0.0), rotation=turned)


def in_the_plane(node: Node, notes: list[str]) -> tuple[float, float, float]:
    """Return x [m], y [m] and yaw [rad], in (-pi, pi], of a planar joint's transform."""
    where = read_placement(node, notes)
    x, y, z = where.translation.tolist()
    tilt = float(np.linalg.norm(where.rotation[:2, 2]))
    if max(abs(z), tilt) > OFF_THE_PLANE or where.rotation[2, 2] < 0.0:
        raise node.error("a planar joint cannot raise or tilt the robot")
    return x, y, float(np.arctan2(where.rotation[1, 0], where.rotation[0, 0]))


def split(trajectory: Trajectory) -> tuple[Trajectory | None, Trajectory | None]:
    several = [stem + suffix for stem in planar_joints(trajectory.joint_names) for suffix in PLANAR]
    single = [name for name in trajectory.joint_names if name not in several]
    return _part(trajectory, single), _part(trajectory, several)


def joined(node: Node, single: Trajectory, several: Trajectory | None) -> Trajectory:
    """Return one trajectory of single and, if any, planar joints; with rates if both parts have them."""
    if several is None:
        return single
    if not np.array_equal(single.times, several.times):
        raise node.error("its two lists of points are at different times")

    def both(one: Floats | None, other: Floats | None) -> Floats | None:
        return None if one is None or other is None else np.hstack((other, one))

    return Trajectory(
        (*several.joint_names, *single.joint_names),
        single.times,
        np.hstack((several.positions, single.positions)),
        both(single.velocities, several.velocities),
        both(single.accelerations, several.accelerations),
    )


def turned_from(start: Mapping[str, float], trajectory: Trajectory) -> Trajectory:
    """Return a trajectory with the yaw of its planar joints shifted by full turns to match the start.

    Args:
        start: Joint -> start position [rad | m]; other joints are unchanged.
    """
    positions = np.array(trajectory.positions)
    for stem in planar_joints(trajectory.joint_names):
        yaw = stem + PLANAR[-1]
        if yaw in start:
            column = trajectory.joint_names.index(yaw)
            positions[:, column] += _TURN * np.round((start[yaw] - positions[0, column]) / _TURN)
    return replace(trajectory, positions=positions)


def read_multi_dof(node: Node) -> Trajectory | None:
    """Return the trajectory of planar joints in a `trajectory_msgs/MultiDOFJointTrajectory`, or None.

    The yaw starts in (-pi, pi] and continues with the nearest full turn at each point.
    """
    points = node["points"].elements()
    if not points:
        return None
    names = [name.text() for name in node["joint_names"].elements()]
    if not names or len(set(names)) != len(names):
        raise node["joint_names"].error("must name every joint once")
    columns = [_rows(points, key, len(names)) for key in ("transforms", "velocities", "accelerations")]
    positions, velocities, accelerations = columns
    if positions is None:
        raise points[0].error("has no transforms")
    positions[:, 2::3] = np.unwrap(positions[:, 2::3], axis=0)
    every = tuple(name + suffix for name in names for suffix in PLANAR)
    kept = accelerations if velocities is not None else None
    return Trajectory(every, read_times(node["points"]), positions, velocities, kept)


def _part(trajectory: Trajectory, names: Sequence[str]) -> Trajectory | None:
    if not names:
        return None
    order = [trajectory.joint_names.index(name) for name in names]
    rates = (trajectory.velocities, trajectory.accelerations)
    return Trajectory(
        tuple(names),
        trajectory.times,
        trajectory.positions[:, order],
        *(None if rows is None else rows[:, order] for rows in rates),
    )


def _rows(points: Sequence[Node], key: str, count: int) -> Floats | None:
    rows: list[list[float]] = []
    for point in points:
        elements = point[key].elements()
        if bool(elements) != bool(points[0][key].elements()):
            raise point.error(f"has other {key} than the first point")
        if elements and len(elements) != count:
            raise point[key].error(f"{len(elements)} {key} for {count} joints")
        read = (in_the_plane(each, []) if key == "transforms" else _rates(each) for each in elements)
        rows.append([number for each in read for number in each])
    return np.array(rows) if rows[0] else None


def _rates(node: Node) -> tuple[float, float, float]:
    node.only(field_names(msg.Twist))
    nothing = (0.0, 0.0, 0.0)
    x, y, z = read_vector(node["linear"]) or nothing
    roll, pitch, yaw = read_vector(node["angular"]) or nothing
    if any((z, roll, pitch)):
        raise node.error("a planar joint cannot raise or tilt the robot")
    return x, y, yaw


@checked
def write_trajectory(trajectory: Trajectory, path: Path | str) -> None:
    """Write a trajectory as `moveit_msgs/RobotTrajectory`: JSON if the file name ends in .json, else YAML.

    Points are at whole nanoseconds (`on_whole_nanoseconds`); numbers are written exactly. A planar base is
    written as in MoveIt: as a joint of several degrees of freedom, by its transforms, which lose full turns.
    """
    write_message(path, trajectory_document(trajectory_message(trajectory)))


def read_joint_trajectory(document: Node) -> Trajectory:
    """Return the trajectory of a robot trajectory message.

    Planar joints become `NAME/x`, `NAME/y` and `NAME/theta`, before the others; see `read_multi_dof`.
    """
    document.only(field_names(msg.RobotTrajectory))
    several = read_multi_dof(document["multi_dof_joint_trajectory"])
    single = document["joint_trajectory"]
    if several is not None and not single["points"].elements():
        return several
    return joined(document, read_points(single), several)


def trajectory_message(trajectory: Trajectory | None, frame: str = "") -> msg.RobotTrajectory:
    """Return a trajectory as a message with its points at whole nanoseconds; an empty message for None.

    Velocities and accelerations of planar joints are derivatives of x, y and yaw: MoveIt, too, states them in
    the frame of the transforms.
    """
    if trajectory is None:
        return msg.RobotTrajectory()
    single, several = split(on_whole_nanoseconds(trajectory))
    message = msg.RobotTrajectory()
    if single is not None:
        names = list(single.joint_names)
        message.joint_trajectory = msg.JointTrajectory(msg.Header(frame_id=frame), names, _points(single))
    if several is not None:
        message.multi_dof_joint_trajectory = msg.MultiDOFJointTrajectory(
            msg.Header(frame_id=frame), list(planar_joints(several.joint_names)), _transforms(several)
        )
    return message


def trajectory_document(message: msg.RobotTrajectory | msg.JointTrajectory) -> dict[str, object]:
    document = encode(message)
    for inner in (document, *document.values()):
        if isinstance(inner, dict) and "points" in inner:
            points = cast("list[dict[str, object]]", inner["points"])
            inner["points"] = [{key: each for key, each in point.items() if each != []} for point in points]
    return document


def _points(trajectory: Trajectory) -> list[msg.JointTrajectoryPoint]:
    return [
        msg.JointTrajectoryPoint(
            trajectory.positions[place].tolist(),
            [] if trajectory.velocities is None else trajectory.velocities[place].tolist(),
            [] if trajectory.accelerations is None else trajectory.accelerations[place].tolist(),
            time_from_start=msg.Duration(moment),
        )
        for place, moment in enumerate(trajectory.times.tolist())
    ]


def _transforms(trajectory: Trajectory) -> list[msg.MultiDOFJointTrajectoryPoint]:
    return [
        msg.MultiDOFJointTrajectoryPoint(
            [transform_of(planar_placement(*row)) for row in _by_joint(trajectory.positions[place])],
            _twists(trajectory.velocities, place),
            _twists(trajectory.accelerations, place),
            msg.Duration(moment),
        )
        for place, moment in enumerate(trajectory.times.tolist())
    ]


def _twists(rows: Floats | None, place: int) -> list[msg.Twist]:
    rates = [] if rows is None else _by_joint(rows[place])
    return [msg.Twist(msg.Vector3(x, y, 0.0), msg.Vector3(0.0, 0.0, yaw)) for x, y, yaw in rates]


def _by_joint(row: Floats) -> list[list[float]]:
    return row.reshape(-1, len(PLANAR)).tolist()


def trajectory_of(message: object, name: str, group: Group, start: Mapping[str, float]) -> Trajectory | None:
    """Return the trajectory of a RobotTrajectory or JointTrajectory message; None if it has no points.

    Args:
        start: Joint -> position [rad | m]: a base's whole turns continue from there.

    Raises:
        FileFormatError: If it is malformed.
        JointNotFound: If a joint of the group is missing.
        ShapeError: If it moves other joints.
    """
    whole = message if is_message(message, "joint_trajectory") else msg.RobotTrajectory(message)  # pyright: ignore[reportArgumentType]
    document = document_of(whole, name)
    lists = ("joint_trajectory", "multi_dof_joint_trajectory")
    if not any(document[each]["points"].elements() for each in lists):
        return None
    return turned_from(start, read_joint_trajectory(document)).ordered(group.joints)


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
    velocities and accelerations, optional for all joints.
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
    if times[0] != 0.0:
        raise FileFormatError(str(path), f"row 1, time: must be 0, is {times[0]:g} s")
    for row, (before, after) in enumerate(pairwise(times.tolist()), start=2):
        if after <= before:
            raise FileFormatError(str(path), f"row {row}, time: {after:g} s does not come after {before:g} s")
    rows = [
        table[:, [columns.index(f"{order}_{name}") for name in names]]
        if f"{order}_{names[0]}" in columns
        else None
        for order in ORDERS
    ]
    assert rows[0] is not None
    return Trajectory(names, times, rows[0], rows[1], rows[2])


def _joints(path: Path | str, columns: Sequence[str]) -> tuple[str, ...]:
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


@checked
def read_trajectory(path: Path | str) -> Trajectory:
    """Read a trajectory in any format that trajopt writes, except URScript.

    A plan's JSON, a `moveit_msgs/RobotTrajectory`, a `trajectory_msgs/JointTrajectory`, or the goal of a
    `control_msgs/action/FollowJointTrajectory` (each JSON if the file name ends in .json, else YAML), or a
    table in .csv (`read_table`). Points are interpolated by quintic polynomials with accelerations, by cubic
    ones with velocities, else linearly. Tolerances of a goal are ignored.

    Raises:
        FileFormatError: If the file is incomplete or malformed.
    """
    if Path(path).suffix.lower() == ".csv":
        return read_table(path)
    document = _document(path)
    if document.has("status") and not document["points"].elements():
        raise document.error(f"holds no motion: {document['message'].text('')}")
    if document.has("trajectory"):
        document.only(field_names(msg.FollowJointTrajectoryGoal))
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
