"""Scenes as messages: world objects, attached objects and allowed contacts."""

from collections.abc import Mapping

from trajopt.files.messages.geometry_msgs import Point
from trajopt.files.messages.moveit_msgs import (
    AllowedCollisionEntry,
    AllowedCollisionMatrix,
    AttachedCollisionObject,
    CollisionObject,
)
from trajopt.files.messages.shape_msgs import Mesh as MeshMessage
from trajopt.files.messages.shape_msgs import MeshTriangle, SolidPrimitive
from trajopt.files.messages.shape_msgs import Plane as PlaneMessage
from trajopt.files.messages.std_msgs import Header
from trajopt.files.moveit.pose import pose_of
from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import SceneObject
from trajopt.values.placement import WORLD, Placement, placement
from trajopt.values.shapes.clouds.points import Points
from trajopt.values.shapes.clouds.surface import centres_of
from trajopt.values.shapes.clouds.voxels import Voxels
from trajopt.values.shapes.mesh_file import Mesh
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Convex, Cylinder, Plane, Shape, Sphere


def world_messages(scene: Scene, frame: str) -> Mapping[str, CollisionObject]:
    """Return the world objects, by id, in the planning frame.

    Args:
        scene: The scene.
        frame: Name of the planning frame.
    """
    return {
        name: object_message(item, scene.holder(name).placement, frame, scene)
        for name, item in scene.objects.items()
        if item.parts and scene.holder(name).link == WORLD
    }


def attached_messages(scene: Scene) -> Mapping[str, AttachedCollisionObject]:
    """Return the attached objects, by id."""
    found: dict[str, AttachedCollisionObject] = {}
    for name, item in scene.objects.items():
        holder = scene.holder(name)
        if item.parts and holder.link != WORLD:
            link, where = holder.link, holder.placement
            if item.frame in scene.frame_names:
                link, where = item.frame, item.placement
            message = object_message(item, where, link, scene)
            found[name] = AttachedCollisionObject(link, message, sorted(item.touch_links))
    return found


def object_message(item: SceneObject, where: Placement, frame: str, scene: Scene) -> CollisionObject:
    """Return an object as a message.

    Args:
        item: The object.
        where: Placement of the object in the frame.
        frame: The frame.
        scene: The scene of the object, with the frames on it.
    """
    message = CollisionObject(header=Header(frame_id=frame), pose=pose_of(where), id=item.name)
    for shape, inner in item.parts:
        _enter(message, shape, inner)
    for key, inner in scene.objects.items():
        if inner.frame == item.name and not inner.parts and key.startswith(f"{item.name}/"):
            message.subframe_names.append(key.removeprefix(f"{item.name}/"))
            message.subframe_poses.append(pose_of(inner.placement))
    return message


def _enter(message: CollisionObject, shape: Shape, where: Placement) -> None:
    match shape:
        case Plane():
            message.planes.append(PlaneMessage([0.0, 0.0, 1.0, 0.0]))
            message.plane_poses.append(pose_of(where))
        case Points() | Voxels():
            # One for each ball or cube; MoveIt's octree has only cubes of one grid.
            one = Sphere(shape.radius) if isinstance(shape, Points) else Box(*(shape.size,) * 3)
            primitive = _primitives(one)[0][0]
            message.primitives += [primitive] * len(shape)
            message.primitive_poses += [pose_of(where * placement(at)) for at in centres_of(shape)]
        case Mesh() | Convex():
            message.meshes.append(mesh_message(shape))
            message.mesh_poses.append(pose_of(where))
        case _:
            for primitive, inner in _primitives(shape):
                message.primitives.append(primitive)
                message.primitive_poses.append(pose_of(where * inner))


def _primitives(shape: Box | Sphere | Cylinder | Cone | Capsule) -> list[tuple[SolidPrimitive, Placement]]:
    """Return a shape as primitives; a capsule is a cylinder between two spheres."""
    here = Placement()
    match shape:
        case Box():
            return [(SolidPrimitive(SolidPrimitive.BOX, [shape.x, shape.y, shape.z]), here)]
        case Sphere():
            return [(SolidPrimitive(SolidPrimitive.SPHERE, [shape.radius]), here)]
        case Cylinder():
            return [(SolidPrimitive(SolidPrimitive.CYLINDER, [shape.length, shape.radius]), here)]
        case Cone():
            return [(SolidPrimitive(SolidPrimitive.CONE, [shape.length, shape.radius]), here)]
        case Capsule():
            tube = SolidPrimitive(SolidPrimitive.CYLINDER, [shape.length, shape.radius])
            ends = [placement((0.0, 0.0, side * shape.length / 2.0)) for side in (-1.0, 1.0)]
            return [
                (tube, here),
                *((SolidPrimitive(SolidPrimitive.SPHERE, [shape.radius]), at) for at in ends),
            ]


def mesh_message(mesh: Mesh | Convex) -> MeshMessage:
    """Return triangles as a message."""
    triangles = [MeshTriangle([int(corner) for corner in face]) for face in mesh.faces]
    return MeshMessage(triangles, [Point(*vertex) for vertex in mesh.vertices.tolist()])


def matrix_message(scene: Scene) -> AllowedCollisionMatrix:
    """Return the allowed contacts as a matrix over all links and objects."""
    names = [*scene.robot.links, *(name for name, item in scene.objects.items() if item.parts)]
    rows = [AllowedCollisionEntry([_excused(scene, a, b) for b in names]) for a in names]
    defaults = scene.allowed.defaults
    return AllowedCollisionMatrix(names, rows, list(defaults), list(defaults.values()))


def _excused(scene: Scene, a: str, b: str) -> bool:
    return a != b and scene.allowed.allowed(a, b)
