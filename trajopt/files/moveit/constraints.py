"""Constraints messages: joint, position, orientation and visibility constraints become requirements."""

from collections.abc import Callable

import numpy as np

from trajopt.files.moveit.frames import Reading, require
from trajopt.files.moveit.orientation_constraint import Orientation, read_orientation
from trajopt.files.moveit.pose import read_tolerance
from trajopt.files.moveit.position_constraint import PointRegion, read_region
from trajopt.files.moveit.visibility_constraint import read_visibility
from trajopt.problem.requirements import (
    FramePlacement,
    JointPositions,
    Requirement,
    RotationCoordinates,
    joint_positions,
)
from trajopt.problem.requirements.requirement import import_installed
from trajopt.scene.scene import Scene
from trajopt.values.arrays import readonly
from trajopt.values.documents.document import Node
from trajopt.values.errors import JointNotFound
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement

CONSTRAINTS_FIELDS = ("name", "joint_constraints", "position_constraints", "orientation_constraints")
Reader = Callable[[Node, Scene, Reading], tuple[Requirement, ...]]
"""Function of one element of a field of a constraints message, the scene and the meaning of names; returns
the
requirements of the element.
"""
READERS: dict[str, Reader] = {"visibility_constraints": read_visibility}
"""Readers of fields whose elements are independent, by field; `reads_constraints` adds one."""
JOINT_FIELDS = ("joint_name", "position", "tolerance_above", "tolerance_below", "weight")
FREE = np.inf


def read_constraints(node: Node, scene: Scene, reading: Reading) -> tuple[tuple[Requirement, ...], Scene]:
    """Return the requirements of a constraints message.

    A position and an orientation of the same frame and reference become one requirement, if the axes of the
    position's region permit it. Weights are ignored: everything is required.

    Args:
        node: The message.
        scene: The scene.
        reading: Meaning of names; its notes receive deviations from the file.

    Returns:
        The requirements, and the scene with the frames that they need.

    Raises:
        FileFormatError: If a constraint is malformed or of an unsupported kind.
        NameNotFound: If it names an unknown joint, link or frame.
    """
    node.only((*CONSTRAINTS_FIELDS, *_readers(node)))
    found: list[Requirement] = [*_read_joints(node["joint_constraints"], scene)]
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
def reads_constraints(field: str) -> Callable[[Reader], Reader]:
    """Register a reader for an additional field of constraints messages.

    Use `@reads_constraints("gap_constraints")` on a function that converts one element of the field to
    requirements. Its module is imported like the modules of other kinds of requirements.
    """

    def register(reader: Reader) -> Reader:
        READERS[field] = reader
        return reader

    return register


def _readers(node: Node) -> tuple[str, ...]:
    """Return the fields with readers; import installed packages if one is missing."""
    if not node.has_only((*CONSTRAINTS_FIELDS, *READERS)):
        import_installed()
    return tuple(READERS)


def _read_joints(nodes: Node, scene: Scene) -> tuple[JointPositions, ...]:
    positions: dict[str, float] = {}
    below: dict[str, float] = {}
    above: dict[str, float] = {}
    for node in nodes.elements():
        joint = node.only(JOINT_FIELDS)["joint_name"].text()
        require(node["joint_name"], JointNotFound, "joint", joint, scene.robot.joint_names)
        if joint in positions:
            raise node["joint_name"].error(f"joint {joint!r} is constrained twice")
        positions[joint] = node["position"].number()
        below[joint] = read_tolerance(node["tolerance_below"])
        above[joint] = read_tolerance(node["tolerance_above"])
    return (joint_positions(positions, below=below, above=above),) if positions else ()


def _share_axes(region: PointRegion, orientation: Orientation) -> bool:
    return (
        region.frame == orientation.original
        and region.reference == orientation.reference
        and (region.turnable or np.allclose(region.placement.rotation, orientation.rotation, atol=1e-9))
    )


def _oriented(
    orientation: Orientation, region: PointRegion | None, node: Node, reading: Reading
) -> tuple[Requirement, ...]:
    """Return the requirement of an orientation, combined with a region if given."""
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
