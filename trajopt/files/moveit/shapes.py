"""Shapes of a collision object message: primitives, meshes and planes with their poses."""

from collections.abc import Callable
from math import hypot

import numpy as np

from trajopt.files import messages
from trajopt.files.messages import SolidPrimitive, field_names
from trajopt.files.moveit.pose import read_placement, read_vector
from trajopt.scene.scene_object import Part
from trajopt.values.documents.document import Node
from trajopt.values.errors import ShapeError, shown
from trajopt.values.placement import IDENTITY, placement
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Cone, Cylinder, Plane, Shape, Sphere

PRIMITIVES = {1: "box", 2: "sphere", 3: "cylinder", 4: "cone", 5: "prism"}
DIMENSIONS = {
    "box": ("x", "y", "z"),
    "sphere": ("radius",),
    "cylinder": ("height", "radius"),
    "cone": ("height", "radius"),
}


def read_parts(node: Node, notes: list[str]) -> tuple[Part, ...]:
    """Return the shapes of a collision object, each with its placement in the object's frame.

    Args:
        node: The collision object message.
        notes: Receives a sentence for every plane, and for every quaternion not of unit length.

    Raises:
        FileFormatError: If a shape is malformed or of an unsupported kind.
    """

    def plane(element: Node) -> Part:
        notes.append(f"{element.place}: the space below the plane is solid")
        return read_plane(element)

    return (
        *_posed(node, "primitives", "primitive_poses", lambda e: (read_primitive(e), IDENTITY), notes),
        *_posed(node, "meshes", "mesh_poses", lambda e: (read_mesh(e), IDENTITY), notes),
        *_posed(node, "planes", "plane_poses", plane, notes),
    )


def _posed(node: Node, shapes: str, poses: str, read: Callable[[Node], Part], notes: list[str]) -> list[Part]:
    elements, places = node[shapes].elements(), node[poses].elements()
    if len(places) > len(elements):
        raise node[poses].error(f"{len(places)} poses for {len(elements)} {shapes}")
    where = [read_placement(place, notes) for place in places]
    where += [IDENTITY] * (len(elements) - len(places))
    parts = [read(element) for element in elements]
    return [(shape, outer * inner) for (shape, inner), outer in zip(parts, where, strict=True)]


def read_kind(node: Node) -> tuple[str, list[Node]]:
    """Return the kind of a solid primitive and the dimensions of that kind."""
    node.only(field_names(SolidPrimitive))
    kind = node["type"].value
    name = kind.lower() if isinstance(kind, str) else ""
    if isinstance(kind, int) and not isinstance(kind, bool):
        name = PRIMITIVES.get(kind, name)
    if name not in DIMENSIONS:
        raise node["type"].error(f"no shape {shown(kind)} here; known: {', '.join(DIMENSIONS)}")
    sizes = node["dimensions"].elements()
    if len(sizes) != len(DIMENSIONS[name]):
        wanted = ", ".join(DIMENSIONS[name])
        raise node["dimensions"].error(f"a {name} has [{wanted}], not {len(sizes)} numbers")
    return name, sizes


def read_primitive(node: Node) -> Shape:
    """Return a box, sphere, cylinder or cone."""
    kind, nodes = read_kind(node)
    sizes = [size.number() for size in nodes]
    try:
        match kind:
            case "box":
                return Box(*sizes)
            case "sphere":
                return Sphere(*sizes)
            case "cylinder":
                return Cylinder(radius=sizes[1], length=sizes[0])
            case _:
                return Cone(radius=sizes[1], length=sizes[0])
    except ShapeError as error:
        raise node["dimensions"].error(str(error)) from error


def read_mesh(node: Node) -> Mesh:
    """Return a mesh of triangles."""
    node.only(field_names(messages.Mesh))
    vertices: list[tuple[float, ...]] = []
    for vertex in node["vertices"].elements():
        point = read_vector(vertex)
        if point is None:
            raise vertex.error("is not a point")
        vertices.append(point)
    triangles: list[list[int]] = []
    for triangle in node["triangles"].elements():
        row = triangle if isinstance(triangle.value, list) else triangle["vertex_indices"]
        indices = row.numbers()
        if len(indices) != 3 or any(i not in range(len(vertices)) for i in indices):
            raise row.error(f"must be three of the {len(vertices)} vertices")
        triangles.append([int(i) for i in indices])
    corners = np.array(vertices, dtype=np.float64).reshape(-1, 3)
    mesh = Mesh(corners, np.array(triangles, dtype=np.int32).reshape(-1, 3))
    if not len(mesh.faces):
        raise node.error("a mesh without triangles")
    return mesh


def read_plane(node: Node) -> Part:
    """Return the half-space a x + b y + c z + d <= 0 of a plane's coefficients [a, b, c, d]."""
    from scipy.spatial.transform import Rotation

    coefficients = node.only(field_names(messages.Plane))["coef"].numbers()
    if len(coefficients) != 4:
        raise node["coef"].error(f"a plane has [a, b, c, d], not {len(coefficients)} numbers")
    normal, offset = np.array(coefficients[:3]), coefficients[3]
    length = hypot(*coefficients[:3])
    if not 1e-9 < length < np.inf:
        raise node["coef"].error(f"the normal of the plane has the length {length:g}")
    up = normal / length
    turn = Rotation.align_vectors(up, np.array((0.0, 0.0, 1.0)))[0]
    return Plane(), placement(-offset / length * up, rotation=turn.as_matrix())
