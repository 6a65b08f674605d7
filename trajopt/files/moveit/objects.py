"""Collision object messages: their shapes, objects of the world, and objects attached to links."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import hypot

import numpy as np

from trajopt.files import messages
from trajopt.files.messages import AttachedCollisionObject, CollisionObject, SolidPrimitive, field_names
from trajopt.files.moveit.frames import (
    Reading,
    placement_in_world,
    read_frame,
    read_placement,
    read_vector,
    require,
)
from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import Part
from trajopt.values.documents.document import Node
from trajopt.values.errors import FrameNotFound, ModelError, NameNotFound, ObjectNotFound, ShapeError, shown
from trajopt.values.placement import IDENTITY, WORLD, Placement, placement
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Cone, Cylinder, Plane, Shape, Sphere

OPERATIONS = ("ADD", "REMOVE", "APPEND", "MOVE")


@dataclass(frozen=True, eq=False)
class ObjectMessage:
    """A collision object message.

    Attributes:
        placement: Of the object in the frame of its header.
    """

    node: Node
    name: str
    operation: str
    placement: Placement
    parts: tuple[Part, ...]
    subframes: tuple[tuple[str, Placement], ...]


def read_object(node: Node, reading: Reading) -> ObjectMessage:
    """Return the content of a collision object message.

    As in MoveIt, an object without a pose takes the pose of its single shape; its id as a frame then means
    this pose.
    """
    node.only(field_names(CollisionObject))
    parts = read_parts(node, reading.notes)
    where = read_placement(node["pose"], reading.notes)
    if len(parts) == 1 and where == IDENTITY:
        shape, where = parts[0]
        parts = ((shape, IDENTITY),)
    names, poses = node["subframe_names"].elements(), node["subframe_poses"].elements()
    if len(names) != len(poses):
        raise node["subframe_names"].error(f"{len(names)} names, but {len(poses)} poses")
    subframes = tuple(
        (name.text(), read_placement(pose, reading.notes)) for name, pose in zip(names, poses, strict=True)
    )
    operation = read_operation(node["operation"])
    return ObjectMessage(node, node["id"].text(""), operation, where, parts, subframes)


def read_operation(node: Node) -> str:
    value = node.value
    if isinstance(value, bytes | str) and len(value) == 1:
        value = ord(value)
    if value is None:
        return OPERATIONS[0]
    if isinstance(value, int) and value in range(len(OPERATIONS)) and not isinstance(value, bool):
        return OPERATIONS[value]
    if isinstance(value, str) and value.upper() in OPERATIONS:
        return value.upper()
    raise node.error(f"unknown operation {shown(value)}; known: {', '.join(OPERATIONS)}")


def apply_object(message: ObjectMessage, scene: Scene, reading: Reading) -> Scene:
    """Return the scene after a collision object message on a world object.

    A frame of the robot or of an object is taken at its current pose; the object stays fixed in the world.
    """
    node, name = message.node, message.name
    if message.operation == "REMOVE":
        if not name:
            placed = world_objects(scene)
            kept = {
                key: item
                for key, item in scene.objects.items()
                if key not in placed or (item.frame == WORLD and not item.parts)
            }
            return _without_lost_tools(replace(scene, objects=kept), scene)
        if name not in world_objects(scene):
            reading.notes.append(f"{node.place}: there is no object {name!r} in the world to remove")
            return scene
        return _without_lost_tools(without(scene, name), scene)
    frame = read_frame(node["header"], scene, reading)
    where = placement_in_world(frame, scene, reading) * message.placement
    if message.operation == "MOVE":
        require(node["id"], ObjectNotFound, "object in the world", name, world_objects(scene))
        if message.parts:
            reading.notes.append(f"{node.place}: the shapes of an object that moves are ignored")
        return scene.move(name, where, frame=WORLD)
    if message.operation == "APPEND" and name in scene.objects:
        here = placement_in_world(name, scene, reading).inverse() * where
        return append(message, here, scene, reading)
    if name in scene.objects:
        reading.notes.append(f"{node.place}: replaces the object {name!r} above it")
    return add(message, scene, reading, placement=where, frame=WORLD)


def world_objects(scene: Scene) -> tuple[str, ...]:
    """Return the objects that are not attached to the robot."""
    return tuple(name for name in scene.objects if scene.holder(name).link == WORLD)


def add(
    message: ObjectMessage,
    scene: Scene,
    reading: Reading,
    *,
    placement: Placement,
    frame: str,
    touch_links: frozenset[str] = frozenset(),
) -> Scene:
    """Return the scene with the message's object in `frame`, replacing any object of the same id."""
    name = message.name
    if not message.parts:
        raise message.node.error(f"object {name!r} has no shape")
    try:
        scene = without(scene, name).add(
            name,
            message.parts,
            placement,
            frame=frame,
            touch_links=touch_links,
            meshes=reading.meshes,
        )
    except NameNotFound:
        raise
    except ModelError as error:
        raise message.node.error(str(error)) from error
    return with_subframes(message, IDENTITY, scene)


def append(message: ObjectMessage, placement: Placement, scene: Scene, reading: Reading) -> Scene:
    name = message.name
    try:
        added = Scene(scene.robot).add(name, message.parts, meshes=reading.meshes).object(name)
    except ModelError as error:
        raise message.node.error(str(error)) from error
    item = scene.object(name)
    moved = tuple((shape, placement * inner) for shape, inner in added.parts)
    item = replace(item, parts=(*item.parts, *moved), notes=(*item.notes, *added.notes))
    scene = replace(scene, objects={**scene.objects, name: item})
    return with_subframes(message, placement, scene)


def with_subframes(message: ObjectMessage, placement: Placement, scene: Scene) -> Scene:
    for name, where in message.subframes:
        frame = f"{message.name}/{name}"
        scene = without(scene, frame).add(frame, (), placement * where, frame=message.name)
    return scene


def without(scene: Scene, name: str) -> Scene:
    """Return the scene without an object and its frames, if the object exists."""
    if name not in scene.objects:
        return scene
    kept = {
        key: item
        for key, item in scene.objects.items()
        if key != name and not (item.frame == name and key.startswith(f"{name}/"))
    }
    return replace(scene, objects=kept)


def _without_lost_tools(scene: Scene, before: Scene) -> Scene:
    owners = {name: before.owner(name) for name in scene.tools}
    gone = set(before.objects) - set(scene.objects)
    return replace(scene, tools={name: scene.tools[name] for name in owners if owners[name] not in gone})


def apply_attached(node: Node, scene: Scene, reading: Reading) -> Scene:
    """Return the scene after an attached collision object message.

    A message with shapes creates the object; without shapes, it attaches the world object of that id at its
    current pose. APPEND adds shapes to the attached object. REMOVE leaves the object in the world at its
    pose.
    """
    node.only(field_names(AttachedCollisionObject))
    message = read_object(node["object"], reading)
    if message.operation == "REMOVE":
        return _detach(node, message.name, scene, reading)
    if message.operation == "MOVE":
        raise node["object"].error(f"{message.operation} of an attached object is not supported")
    if node["weight"].number(0.0) != 0.0:
        reading.notes.append(f"{node.place}: the weight of {message.name!r} is ignored")
    link = node["link_name"].text()
    require(node["link_name"], FrameNotFound, "link", link, scene.frame_names)
    touch = [link_node.text() for link_node in node["touch_links"].elements()]
    for link_node in node["touch_links"].elements():
        require(link_node, FrameNotFound, "link", link_node.text(), (*scene.frame_names, *scene.objects))
    if message.operation == "APPEND" and _carries(link, message.name, scene):
        return _append(message, frozenset(touch), scene, reading)
    if message.parts:
        return _attach_new(message, link, frozenset(touch), scene, reading)
    require(node["object"]["id"], ObjectNotFound, "object", message.name, scene.objects)
    return scene.attach(message.name, link, at=reading.positions, touch_links=touch)


def _carries(link: str, name: str, scene: Scene) -> bool:
    return name in scene.objects and link in (scene.object(name).frame, scene.holder(name).link)


def _append(message: ObjectMessage, touch: frozenset[str], scene: Scene, reading: Reading) -> Scene:
    frame = read_frame(message.node["header"], scene, reading)
    here = placement_in_world(message.name, scene, reading).inverse()
    there = here * placement_in_world(frame, scene, reading) * message.placement
    scene = append(message, there, scene, reading)
    item = scene.object(message.name)
    item = replace(item, touch_links=frozenset(item.touch_links) | touch)
    return replace(scene, objects={**scene.objects, message.name: item})


def _attach_new(
    message: ObjectMessage, link: str, touch: frozenset[str], scene: Scene, reading: Reading
) -> Scene:
    frame = read_frame(message.node["header"], scene, reading)
    where = message.placement
    if frame != link:
        at_link = placement_in_world(link, scene, reading)
        where = at_link.inverse() * placement_in_world(frame, scene, reading) * where
    touch |= {scene.holder(link).link}
    return add(message, scene, reading, placement=where, frame=link, touch_links=touch)


def _detach(node: Node, name: str, scene: Scene, reading: Reading) -> Scene:
    link = node["link_name"].text("")
    held = [
        key
        for key, item in scene.objects.items()
        if item.frame in scene.frame_names
        and scene.holder(key).link != WORLD
        and name in ("", key)
        and link in ("", item.frame)
    ]
    if name and not held:
        reading.notes.append(f"{node.place}: there is no attached object {name!r} to detach")
    for key in held:
        scene = scene.detach(key, at=reading.positions)
    return scene


PRIMITIVES = {1: "box", 2: "sphere", 3: "cylinder", 4: "cone", 5: "prism"}
DIMENSIONS = {
    "box": ("x", "y", "z"),
    "sphere": ("radius",),
    "cylinder": ("height", "radius"),
    "cone": ("height", "radius"),
}


def read_parts(node: Node, notes: list[str]) -> tuple[Part, ...]:
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
