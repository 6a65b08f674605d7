"""Orientation constraint messages: a frame's orientation, with a tolerance about each axis."""

from dataclasses import dataclass

import numpy as np

from trajopt.files.moveit.frames import Reading, read_frame, read_frame_name
from trajopt.files.moveit.pose import read_quaternion, read_tolerance
from trajopt.problem.requirements import RotationCoordinates
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node
from trajopt.values.placement import placement

ORIENTATION_FIELDS = (
    *("header", "orientation", "link_name", "absolute_x_axis_tolerance"),
    *("absolute_y_axis_tolerance", "absolute_z_axis_tolerance", "parameterization", "weight"),
)


@dataclass(frozen=True, eq=False)
class Orientation:
    """A frame's orientation.

    Attributes:
        frame: The frame, or a copy of it that is turned.
        reference: The frame that the orientation is seen from.
        rotation: Of the frame in the reference, shape (3, 3).
        tolerance: About each axis of `rotation`, shape (3,) [rad]; inf leaves an axis free.
        coordinates: How the error is expressed.
        original: The frame that is meant.
        turn: From the coordinates of `original` to those of `frame`, shape (3, 3).
    """

    frame: str
    reference: str
    rotation: Floats
    tolerance: Floats
    coordinates: RotationCoordinates
    original: str
    turn: Floats


def read_orientation(node: Node, scene: Scene, reading: Reading) -> tuple[Orientation, Scene]:
    """Return the orientation that a message requires.

    Args:
        node: The message.
        scene: The scene.
        reading: What names mean; its notes receive what was taken differently.

    Returns:
        The orientation, and the scene with the turned copy of the frame where it needs one.

    Raises:
        FileFormatError: If the message is malformed.
        FrameNotFound: If it names an unknown frame.
    """
    node.only(ORIENTATION_FIELDS)
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
    """Return a rotation vector's tolerance, which MoveIt takes along the axes of the header.

    A requirement has it along those of the goal orientation R_g. Where R_g only renames axes, the
    tolerances are renamed with them. Else the link gets a copy of its frame, turned by R_g^T, so
    that the copy's goal is the header's own axes: log(R R_g^T) = log(I^T (R R_g^T)).
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
