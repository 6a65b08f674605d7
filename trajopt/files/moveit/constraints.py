"""Constraints messages: joint, position, orientation and visibility constraints become requirements."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from trajopt.files import messages as msg
from trajopt.files.messages import field_names
from trajopt.files.moveit.frames import (
    LEAST_TOLERANCE,
    Reading,
    read_frame,
    read_frame_name,
    read_placement,
    read_quaternion,
    read_tolerance,
    read_vector,
    require,
)
from trajopt.files.moveit.objects import read_kind
from trajopt.problem.requirement import import_installed
from trajopt.problem.requirements import (
    FramePlacement,
    JointPositions,
    Requirement,
    RotationCoordinates,
    axis_alignment,
    gaze,
    joint_positions,
)
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, readonly
from trajopt.values.documents.document import Node
from trajopt.values.errors import JointNotFound
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement, placement

VIEW_AXES = (2, 1, 0)
"""Column of the sensor's axis by `sensor_view_direction`: z, y, x."""

ConstraintReader = Callable[[Node, Scene, Reading], tuple[Requirement, ...]]
"""Function of one element of a constraints field, the scene and the meaning of names; returns its
requirements.
"""
FREE = np.inf


@dataclass(frozen=True, eq=False)
class PointRegion:
    """A box that must contain a point of a frame.

    Attributes:
        tolerance: Half its edges, shape (3,) [m]; inf leaves an axis free.
        turnable: Whether the box may be rotated, as a box inside a sphere may.
    """

    frame: str
    reference: str
    placement: Placement
    tolerance: Floats
    offset: Floats
    turnable: bool


def read_region(node: Node, scene: Scene, reading: Reading) -> PointRegion:
    """Return the region of a position constraint; of a sphere, the cube inside it."""
    region = node.only(field_names(msg.PositionConstraint))["constraint_region"].only(
        field_names(msg.BoundingVolume)
    )
    primitives, poses = region["primitives"].elements(), region["primitive_poses"].elements()
    if region["meshes"].elements():
        raise region["meshes"].error("a region can be a box or a sphere, not a mesh")
    if not primitives or len(poses) > len(primitives):
        raise region.error(f"{len(primitives)} primitives, but {len(poses)} poses")
    if len(primitives) > 1:
        reading.notes.append(f"{region.place}: the first of {len(primitives)} regions is taken")
    kind, sizes = read_kind(primitives[0])
    if kind == "box":
        tolerance = np.array([_half_edge(size, reading) for size in sizes])
    elif kind == "sphere":
        radius = read_tolerance(sizes[0])
        tolerance = np.full(3, radius / np.sqrt(3.0))
        reading.notes.append(f"{region.place}: the cube inside the sphere of {radius:g} m is taken")
    else:
        raise primitives[0].error(f"a region can be a box or a sphere, not a {kind}")
    return PointRegion(
        read_frame_name(node["link_name"], scene),
        read_frame(node["header"], scene, reading),
        read_placement(poses[0], reading.notes) if poses else Placement(),
        tolerance,
        np.array(read_vector(node["target_point_offset"], optional="xyz") or (0.0, 0.0, 0.0)),
        kind == "sphere",
    )


def _half_edge(size: Node, reading: Reading) -> float:
    # OMPL projections write -1 for a free axis.
    edge = size.number(infinite=True)
    if edge < 0.0:
        reading.notes.append(f"{size.place}: an edge of {edge:g} leaves the axis free")
        return np.inf
    return edge / 2.0 or LEAST_TOLERANCE


@dataclass(frozen=True, eq=False)
class Orientation:
    """A required orientation of a frame.

    Attributes:
        rotation: Of the frame in the reference, shape (3, 3).
        tolerance: About each axis of `rotation`, shape (3,) [rad]; inf leaves an axis free.
        turn: Rotation from the coordinates of `original` to the coordinates of `frame`, shape (3, 3).
    """

    frame: str
    reference: str
    rotation: Floats
    tolerance: Floats
    coordinates: RotationCoordinates
    original: str
    turn: Floats


def read_orientation(node: Node, scene: Scene, reading: Reading) -> tuple[Orientation, Scene]:
    """Return the orientation required by a message, and the scene with the frames that it needs."""
    node.only(field_names(msg.OrientationConstraint))
    link = read_frame_name(node["link_name"], scene)
    reference = read_frame(node["header"], scene, reading)
    rotation = placement(quaternion=read_quaternion(node["orientation"], reading.notes)).rotation
    tolerance = np.array([read_tolerance(node[f"absolute_{axis}_axis_tolerance"]) for axis in "xyz"])
    tolerance[tolerance >= np.pi] = np.inf
    kind = node["parameterization"].number(0.0)
    if kind == 0.0:
        coordinates = RotationCoordinates.XYZ_EULER
    elif kind == 1.0:
        coordinates = RotationCoordinates.ROTATION_VECTOR
    else:
        raise node["parameterization"].error("must be 0 (x-y-z Euler angles) or 1 (rotation vector)")
    if coordinates is RotationCoordinates.ROTATION_VECTOR:
        return _along_header(link, reference, rotation, tolerance, scene)
    return Orientation(link, reference, rotation, tolerance, coordinates, link, np.eye(3)), scene


def _along_header(
    link: str, reference: str, rotation: Floats, tolerance: Floats, scene: Scene
) -> tuple[Orientation, Scene]:
    """Return a rotation vector's tolerance, which MoveIt defines along the axes of the header.

    A requirement defines it along the axes of the goal orientation R_g. If R_g only permutes axes, so are the
    tolerances. Otherwise the link gets a copy of its frame, rotated by R_g^T, whose goal is aligned with the
    header's axes: log(R R_g^T) = log(I^T (R R_g^T)).
    """
    vector = RotationCoordinates.ROTATION_VECTOR
    axes = np.abs(rotation).argmax(axis=0)
    if np.allclose(np.abs(rotation), np.eye(3)[:, axes], atol=1e-9):
        renamed = tolerance[axes]
        return Orientation(link, reference, rotation, renamed, vector, link, np.eye(3)), scene
    count = 0
    while f"{link}/turned_{count}" in scene.objects:
        count += 1
    copy = f"{link}/turned_{count}"
    scene = scene.add(copy, (), placement(rotation=rotation.T), frame=link)
    return Orientation(copy, reference, np.eye(3), tolerance, vector, link, rotation), scene


def read_visibility(node: Node, scene: Scene, reading: Reading) -> tuple[Requirement, ...]:
    """Return the requirements of a visibility constraint.

    The range angle becomes a gaze, the view angle an alignment of the sensor's axis with the target's -z.
    Obstacles in the cone are not checked, which is noted.

    Source: MoveIt, `kinematic_constraints::VisibilityConstraint::decide`.
    """
    node.only(field_names(msg.VisibilityConstraint))
    sensor, target = (node[key].only(field_names(msg.PoseStamped)) for key in ("sensor_pose", "target_pose"))
    camera, reference = (read_frame(each["header"], scene, reading) for each in (sensor, target))
    here, there = (read_placement(each["pose"], reading.notes) for each in (sensor, target))
    direction = node["sensor_view_direction"].number(0.0)
    if direction not in range(len(VIEW_AXES)):
        raise node["sensor_view_direction"].error("must be 0 (z), 1 (y) or 2 (x)")
    axis = here.rotation[:, VIEW_AXES[int(direction)]]
    found: list[Requirement] = []
    range_angle, view_angle = _angle(node["max_range_angle"]), _angle(node["max_view_angle"])
    if range_angle > 0.0:
        found.append(
            gaze(
                camera,
                there.translation,
                angle=range_angle,
                axis=axis,
                origin=here.translation,
                reference=reference,
            )
        )
    if view_angle > 0.0:
        facing = -there.rotation[:, 2]
        found.append(
            axis_alignment(camera, axis=axis, direction=facing, tolerance=view_angle, reference=reference)
        )
    if not found:
        raise node.error("has neither max_range_angle nor max_view_angle; the cone alone is not supported")
    reading.notes.append(f"{node.place}: obstacles between sensor and target are not checked")
    return tuple(found)


def _angle(node: Node) -> float:
    angle = node.number(0.0)
    if angle < 0.0:
        raise node.error(f"is negative: {angle:g}")
    return min(angle, np.pi / 2.0)


READERS: dict[str, ConstraintReader] = {"visibility_constraints": read_visibility}
"""Readers of fields whose elements are independent, by field; `reads_constraints` adds one."""


def read_constraints(node: Node, scene: Scene, reading: Reading) -> tuple[tuple[Requirement, ...], Scene]:
    """Return the requirements of a constraints message, and the scene with the frames that they need.

    A position and an orientation of the same frame and reference become one requirement, if the axes of the
    position's region permit it. Weights are ignored: everything is required.

    Args:
        reading: Meaning of names; its notes receive deviations from the file.
    """
    node.only((*field_names(msg.Constraints), *_readers(node)))
    found: list[Requirement] = [*_read_joints(node["joint_constraints"], scene, reading)]
    for field, read in READERS.items():
        for element in node[field].elements():
            found.extend(read(element, scene, reading))
    regions = [read_region(element, scene, reading) for element in node["position_constraints"].elements()]
    for element in node["orientation_constraints"].elements():
        orientation, scene = read_orientation(element, scene, reading)
        partner = next((region for region in regions if _share_axes(region, orientation)), None)
        regions = [region for region in regions if region is not partner]
        found.extend(_oriented(orientation, partner, element, reading))
    for region in regions:
        found.extend(_positioned(region, node["position_constraints"], reading))
    return tuple(found), scene


@checked
def reads_constraints(field: str) -> Callable[[ConstraintReader], ConstraintReader]:
    """Register a reader for an additional field of constraints messages.

    `@reads_constraints("gap_constraints")` marks a function that converts one element of the field to
    requirements.
    """

    def register(reader: ConstraintReader) -> ConstraintReader:
        READERS[field] = reader
        return reader

    return register


def _readers(node: Node) -> tuple[str, ...]:
    if not node.has_only((*field_names(msg.Constraints), *READERS)):
        import_installed()
    return tuple(READERS)


def _read_joints(nodes: Node, scene: Scene, reading: Reading) -> tuple[JointPositions, ...]:
    positions: dict[str, float] = {}
    below: dict[str, float] = {}
    above: dict[str, float] = {}
    for node in nodes.elements():
        joint = node.only(field_names(msg.JointConstraint))["joint_name"].text()
        require(node["joint_name"], JointNotFound, "joint", joint, scene.robot.joint_names)
        if joint in positions:
            raise node["joint_name"].error(f"joint {joint!r} is constrained twice")
        positions[joint] = _nearest_turn(node["position"].number(), joint, scene.robot, reading.positions)
        below[joint] = read_tolerance(node["tolerance_below"])
        above[joint] = read_tolerance(node["tolerance_above"])
    return (joint_positions(positions, below=below, above=above),) if positions else ()


def _nearest_turn(position: float, joint: str, robot: Robot, start: Floats) -> float:
    """Add the full turns that bring a position of a continuous joint nearest to the start, as in MoveIt."""
    place = int(robot.index([joint])[0])
    if np.isfinite(robot.limits.lower[place]) or np.isfinite(robot.limits.upper[place]):
        return position
    return position + 2.0 * np.pi * round((float(start[place]) - position) / (2.0 * np.pi))


def _share_axes(region: PointRegion, orientation: Orientation) -> bool:
    return (
        region.frame == orientation.original
        and region.reference == orientation.reference
        and (region.turnable or np.allclose(region.placement.rotation, orientation.rotation, atol=1e-9))
    )


def _oriented(
    orientation: Orientation, region: PointRegion | None, node: Node, reading: Reading
) -> tuple[Requirement, ...]:
    translation, tolerance, offset = np.zeros(3), np.full(3, FREE), np.zeros(3)
    if region is not None:
        translation, tolerance = region.placement.translation, region.tolerance
        offset = orientation.turn @ region.offset
    if np.isinf(tolerance).all() and np.isinf(orientation.tolerance).all():
        reading.notes.append(f"{node.place}: leaves every axis free and requires nothing")
        return ()
    return (
        FramePlacement(  # no size check: messages leave an axis free by a box of metres
            orientation.frame,
            Placement(readonly(np.array(orientation.rotation)), readonly(np.array(translation))),
            orientation.reference,
            readonly(np.array(tolerance)),
            readonly(np.array(orientation.tolerance)),
            orientation.coordinates,
            readonly(np.array(offset)),
        ),
    )


def _positioned(region: PointRegion, node: Node, reading: Reading) -> tuple[Requirement, ...]:
    if np.isinf(region.tolerance).all():
        reading.notes.append(f"{node.place}: leaves every axis free and requires nothing")
        return ()
    return (
        FramePlacement(
            region.frame,
            region.placement,
            region.reference,
            readonly(np.array(region.tolerance)),
            readonly(np.full(3, FREE)),
            RotationCoordinates.ROTATION_VECTOR,
            readonly(np.array(region.offset)),
        ),
    )
