"""Position constraint messages: a point of a frame in a box or sphere."""

from dataclasses import dataclass

import numpy as np

from trajopt.files.moveit.frames import Reading, read_frame, read_frame_name
from trajopt.files.moveit.pose import LEAST_TOLERANCE, read_placement, read_tolerance, read_vector
from trajopt.files.moveit.shapes import read_kind
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node
from trajopt.values.placement import Placement

POSITION_FIELDS = ("header", "link_name", "target_point_offset", "constraint_region", "weight")
REGION_FIELDS = ("primitives", "primitive_poses", "meshes", "mesh_poses")


@dataclass(frozen=True, eq=False)
class PointRegion:
    """A box that must contain a point of a frame.

    Attributes:
        frame: The frame.
        reference: The reference frame of the box.
        placement: Of the box in the reference.
        tolerance: Half its edges, shape (3,) [m]; inf leaves an axis free.
        offset: The point, in the frame, shape (3,) [m].
        turnable: Whether the box may be rotated, as a box inside a sphere may.
    """

    frame: str
    reference: str
    placement: Placement
    tolerance: Floats
    offset: Floats
    turnable: bool


def read_region(node: Node, scene: Scene, reading: Reading) -> PointRegion:
    """Return the region of a position constraint; of a sphere, the cube inside it.

    Args:
        node: The message.
        scene: The scene.
        reading: Meaning of names; its notes receive deviations from the file.

    Raises:
        FileFormatError: If the message is malformed, or the region is neither a box nor a sphere.
        FrameNotFound: If it names an unknown frame.
    """
    region = node.only(POSITION_FIELDS)["constraint_region"].only(REGION_FIELDS)
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
