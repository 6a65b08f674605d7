"""Joint trajectory messages: joint names and points, as in `trajectory_msgs/JointTrajectory`."""

import json
from itertools import pairwise
from math import inf
from pathlib import Path

import numpy as np
import yaml

from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node, write_text
from trajopt.values.errors import ShapeError
from trajopt.values.trajectory import Trajectory

NANOSECONDS = 10**9
_DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)


def write_message(path: Path | str, document: dict[str, object]) -> None:
    """Write a message for `read_document`: JSON if the file name ends in .json, YAML otherwise.

    Raises:
        FileFormatError: If the file cannot be written.
    """
    if Path(path).suffix == ".json":
        text = json.dumps(document, indent=1, allow_nan=False) + "\n"
    else:
        text = yaml.dump_all([document], Dumper=_DUMPER, sort_keys=False, default_flow_style=None, width=110)
    write_text(path, text)


def header() -> dict[str, object]:
    """Return a header with time zero (now) and no frame."""
    return {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}


def read_points(node: Node) -> Trajectory:
    """Return the trajectory of `joint_names` and `points`; other members are ignored.

    Points are interpolated by quintic polynomials if they have accelerations, by cubic polynomials if they
    have only velocities, else linearly. An empty list counts as absent.

    Raises:
        FileFormatError: If something is missing or malformed, points differ in their quantities,
            or time does not increase from 0.
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
    """Return the times of a list of points, shape (k,) [s].

    Raises:
        FileFormatError: If there are less than two, or time does not increase from 0.
    """
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
    """Return a time in seconds, written as a number or as {sec:, nanosec:} (or secs, nsecs)."""
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


def points_document(trajectory: Trajectory) -> dict[str, object]:
    """Return `joint_names` and `points` of a trajectory whose points are at whole nanoseconds.

    Raises:
        ShapeError: If two points are less than a nanosecond apart.
    """
    points: list[dict[str, object]] = []
    for place, moment in enumerate(moments(trajectory)):
        point: dict[str, object] = {
            key: [float(value) for value in rows[place]]
            for key, rows in (
                ("positions", trajectory.positions),
                ("velocities", trajectory.velocities),
                ("accelerations", trajectory.accelerations),
            )
            if rows is not None
        }
        point["time_from_start"] = moment
        points.append(point)
    return {"joint_names": list(trajectory.joint_names), "points": points}


def on_whole_nanoseconds(trajectory: Trajectory) -> Trajectory:
    """Return a motion with its points at whole nanoseconds, the resolution of messages.

    Each point is evaluated on the motion at its rounded time. With the original positions at rounded times,
    the interpolating polynomials would have to compensate the rounding and could exceed the limits.

    Raises:
        ShapeError: If two points are less than a nanosecond apart.
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


def moments(trajectory: Trajectory) -> list[dict[str, int]]:
    """Return the times of a trajectory's points, in whole nanoseconds.

    Raises:
        ShapeError: If two points are less than a nanosecond apart.
    """
    stamps = [round(float(time) * NANOSECONDS) for time in trajectory.times]
    if any(after <= before for before, after in pairwise(stamps)):
        raise ShapeError("times", "two points are less than a nanosecond apart")
    return [{"sec": stamp // NANOSECONDS, "nanosec": stamp % NANOSECONDS} for stamp in stamps]
