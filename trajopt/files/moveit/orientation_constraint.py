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
    """A required orientation of a frame.

    Attributes:
        frame: The frame, or a rotated copy of it.
        reference: The reference frame of the orientation.
        rotation: Of the frame in the reference, shape (3, 3).
        tolerance: About each axis of `rotation`, shape (3,) [rad]; inf leaves an axis free.
        coordinates: Parametrisation of the error.
        original: The frame named in the message.
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
    """Return the orientation required by a message.

    Args:
        node: The message.
        scene: The scene.
        reading: Meaning of names; its notes receive deviations from the file.

    Returns:
        The orientation, and the scene with a rotated copy of the frame if needed.

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
    """Return a rotation vector's tolerance, which MoveIt defines along the axes of the header.

    A requirement defines it along the axes of the goal orientation R_g. If R_g only permutes axes, the
    tolerances are permuted too. Otherwise the link gets a copy of its frame, rotated by R_g^T, whose goal is
    aligned with the header's axes: log(R R_g^T) = log(I^T (R R_g^T)).
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
