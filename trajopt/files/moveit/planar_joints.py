"""Planar joints in MoveIt's messages: one joint with a transform there, three single joints in trajopt."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from trajopt.files.moveit.joint_trajectory import moments, read_times
from trajopt.files.moveit.pose import read_placement, read_vector
from trajopt.robot.bases import PLANAR
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node
from trajopt.values.placement import Placement, from_rpy, placement
from trajopt.values.trajectory import Trajectory

OFF_THE_PLANE = 1e-4
"""Largest deviation of a planar joint's transform from its plane: height or sine of the tilt [m | rad]."""

_TURN = 2.0 * np.pi


def planar_joints(joint_names: Sequence[str]) -> tuple[str, ...]:
    """Return the planar joints whose x, y and theta are all given, by MoveIt's variable names."""
    x, *others = PLANAR
    stems = (name.removesuffix(x) for name in joint_names if name.endswith(x))
    return tuple(stem for stem in stems if all(stem + suffix in joint_names for suffix in others))


def planar_placement(x: float, y: float, yaw: float) -> Placement:
    """Return the placement of a planar joint's link in the parent frame."""
    turned = from_rpy(0.0, 0.0, yaw)  # yaw may include full turns
    return placement((x, y, 0.0), rotation=turned)


def in_the_plane(node: Node, notes: list[str]) -> tuple[float, float, float]:
    """Return x [m], y [m] and yaw [rad], in (-pi, pi], of a planar joint's transform.

    Args:
        node: The transform.
        notes: Receives a sentence for a quaternion not of unit length.

    Raises:
        FileFormatError: If it is malformed, or lies off the plane.
    """
    where = read_placement(node, notes)
    x, y, z = where.translation.tolist()
    tilt = float(np.linalg.norm(where.rotation[:2, 2]))
    if max(abs(z), tilt) > OFF_THE_PLANE or where.rotation[2, 2] < 0.0:
        raise node.error("a planar joint cannot raise or tilt the robot")
    return x, y, float(np.arctan2(where.rotation[1, 0], where.rotation[0, 0]))


def split(trajectory: Trajectory) -> tuple[Trajectory | None, Trajectory | None]:
    """Return the trajectories of single and of planar joints; None for an empty part."""
    several = [stem + suffix for stem in planar_joints(trajectory.joint_names) for suffix in PLANAR]
    single = [name for name in trajectory.joint_names if name not in several]
    return _part(trajectory, single), _part(trajectory, several)


def joined(node: Node, single: Trajectory, several: Trajectory | None) -> Trajectory:
    """Return one trajectory of both; it has velocities and accelerations if both parts have them.

    Args:
        node: The message, for errors.
        single: Trajectory of single joints.
        several: Trajectory of planar joints, if any.

    Raises:
        FileFormatError: If they have points at different times.
    """
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
        start: Joint -> start position [rad | m].
        trajectory: The trajectory; joints that are not in `start` are unchanged.
    """
    positions = np.array(trajectory.positions)
    for stem in planar_joints(trajectory.joint_names):
        yaw = stem + PLANAR[-1]
        if yaw in start:
            column = trajectory.joint_names.index(yaw)
            positions[:, column] += _TURN * np.round((start[yaw] - positions[0, column]) / _TURN)
    return replace(trajectory, positions=positions)


def multi_dof_points(trajectory: Trajectory) -> list[dict[str, object]]:
    """Return the points of planar joints, as in `trajectory_msgs/MultiDOFJointTrajectory`.

    Velocities and accelerations are the derivatives of x, y and yaw, expressed in the frame of the transforms
    as in MoveIt.

    Args:
        trajectory: Of planar joints, with x, y and yaw of each in sequence.

    Raises:
        ShapeError: If two points are less than a nanosecond apart.
    """
    points: list[dict[str, object]] = []
    for place, moment in enumerate(moments(trajectory)):
        placed = [
            planar_placement(x, y, yaw) for x, y, yaw in trajectory.positions[place].reshape(-1, 3).tolist()
        ]
        point: dict[str, object] = {
            "transforms": [
                {
                    "translation": dict(zip("xyz", where.translation.tolist(), strict=True)),
                    "rotation": dict(zip("xyzw", where.quaternion.tolist(), strict=True)),
                }
                for where in placed
            ]
        }
        point["velocities"] = _twists(trajectory.velocities, place)
        point["accelerations"] = _twists(trajectory.accelerations, place)
        points.append({**point, "time_from_start": moment})
    return points


def read_multi_dof(node: Node) -> Trajectory | None:
    """Return the trajectory of planar joints in a `trajectory_msgs/MultiDOFJointTrajectory`, or None.

    The yaw starts in (-pi, pi] and continues with the nearest full turn at each point.

    Raises:
        FileFormatError: If it is malformed, or a transform lies off the plane.
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


def _twists(rows: Floats | None, place: int) -> list[dict[str, dict[str, float]]]:
    if rows is None:
        return []
    return [
        {"linear": {"x": x, "y": y, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": yaw}}
        for x, y, yaw in rows[place].reshape(-1, len(PLANAR)).tolist()
    ]


def _rows(points: Sequence[Node], key: str, count: int) -> Floats | None:
    """Return x, y and yaw of all joints at all points, or their rates, shape (k, 3 count); None if absent."""
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
    node.only(("linear", "angular"))
    nothing = (0.0, 0.0, 0.0)
    x, y, z = read_vector(node["linear"]) or nothing
    roll, pitch, yaw = read_vector(node["angular"]) or nothing
    if any((z, roll, pitch)):
        raise node.error("a planar joint cannot raise or tilt the robot")
    return x, y, yaw
