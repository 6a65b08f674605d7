"""Scenes and robot states as messages, and planning scenes as files."""

from collections.abc import Mapping
from pathlib import Path
from typing import cast

from trajopt.files import messages as msg
from trajopt.files.messages import document_of
from trajopt.files.moveit.frames import pose_of, transform_of
from trajopt.files.moveit.trajectories import planar_joints, planar_placement, write_message
from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import SceneObject
from trajopt.values.arrays import Floats, floats, one_of
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD, Placement, placement
from trajopt.values.shapes.clouds import Points, Voxels, centres_of
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Convex, Cylinder, Plane, Shape, Sphere

WRITTEN = (
    msg.PlanningSceneComponents.ROBOT_STATE
    + msg.PlanningSceneComponents.ROBOT_STATE_ATTACHED_OBJECTS
    + msg.PlanningSceneComponents.WORLD_OBJECT_NAMES
    + msg.PlanningSceneComponents.WORLD_OBJECT_GEOMETRY
    + msg.PlanningSceneComponents.TRANSFORMS
    + msg.PlanningSceneComponents.ALLOWED_COLLISION_MATRIX
    + msg.PlanningSceneComponents.LINK_PADDING_AND_SCALING
)


def world_messages(scene: Scene, frame: str) -> Mapping[str, msg.CollisionObject]:
    """Return the world objects, by id, in the planning frame.

    Args:
        frame: Name of the planning frame.
    """
    return {
        name: object_message(item, scene.holder(name).placement, frame, scene)
        for name, item in scene.objects.items()
        if item.parts and scene.holder(name).link == WORLD
    }


def attached_messages(scene: Scene) -> Mapping[str, msg.AttachedCollisionObject]:
    """Return the attached objects, by id."""
    found: dict[str, msg.AttachedCollisionObject] = {}
    for name, item in scene.objects.items():
        holder = scene.holder(name)
        if item.parts and holder.link != WORLD:
            link, where = holder.link, holder.placement
            if item.frame in scene.frame_names:
                link, where = item.frame, item.placement
            message = object_message(item, where, link, scene)
            found[name] = msg.AttachedCollisionObject(link, message, sorted(item.touch_links))
    return found


def object_message(item: SceneObject, where: Placement, frame: str, scene: Scene) -> msg.CollisionObject:
    """Return an object as a message.

    Args:
        scene: The scene of the object, with the frames on it.
    """
    message = msg.CollisionObject(header=msg.Header(frame_id=frame), pose=pose_of(where), id=item.name)
    for shape, inner in item.parts:
        _enter(message, shape, inner)
    for key, inner in scene.objects.items():
        if inner.frame == item.name and not inner.parts and key.startswith(f"{item.name}/"):
            message.subframe_names.append(key.removeprefix(f"{item.name}/"))
            message.subframe_poses.append(pose_of(inner.placement))
    return message


def _enter(message: msg.CollisionObject, shape: Shape, where: Placement) -> None:
    match shape:
        case Plane():
            message.planes.append(msg.Plane([0.0, 0.0, 1.0, 0.0]))
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


def _primitives(
    shape: Box | Sphere | Cylinder | Cone | Capsule,
) -> list[tuple[msg.SolidPrimitive, Placement]]:
    here = Placement()
    match shape:
        case Box():
            return [(msg.SolidPrimitive(msg.SolidPrimitive.BOX, [shape.x, shape.y, shape.z]), here)]
        case Sphere():
            return [(msg.SolidPrimitive(msg.SolidPrimitive.SPHERE, [shape.radius]), here)]
        case Cylinder():
            return [(msg.SolidPrimitive(msg.SolidPrimitive.CYLINDER, [shape.length, shape.radius]), here)]
        case Cone():
            return [(msg.SolidPrimitive(msg.SolidPrimitive.CONE, [shape.length, shape.radius]), here)]
        case Capsule():
            tube = msg.SolidPrimitive(msg.SolidPrimitive.CYLINDER, [shape.length, shape.radius])
            ends = [placement((0.0, 0.0, side * shape.length / 2.0)) for side in (-1.0, 1.0)]
            return [
                (tube, here),
                *((msg.SolidPrimitive(msg.SolidPrimitive.SPHERE, [shape.radius]), at) for at in ends),
            ]


def mesh_message(mesh: Mesh | Convex) -> msg.Mesh:
    """Return triangles as a message."""
    triangles = [msg.MeshTriangle([int(corner) for corner in face]) for face in mesh.faces]
    return msg.Mesh(triangles, [msg.Point(*vertex) for vertex in mesh.vertices.tolist()])


def matrix_message(scene: Scene) -> msg.AllowedCollisionMatrix:
    names = [*scene.robot.links, *(name for name, item in scene.objects.items() if item.parts)]
    rows = [msg.AllowedCollisionEntry([_excused(scene, a, b) for b in names]) for a in names]
    defaults = scene.allowed.defaults
    return msg.AllowedCollisionMatrix(names, rows, list(defaults), list(defaults.values()))


def _excused(scene: Scene, a: str, b: str) -> bool:
    return a != b and scene.allowed.allowed(a, b)


def state_message(scene: Scene, positions: Floats) -> msg.RobotState:
    """Return positions of all joints, and the attached objects, as a message."""
    robot, at = scene.robot, positions.tolist()
    named = dict(zip(robot.joint_names, at, strict=True))
    several = msg.MultiDOFJointState()
    if planar_joints(robot.base.joints):
        x, y, yaw = (named.pop(joint) for joint in robot.base.joints)
        transform = transform_of(planar_placement(x, y, yaw))
        several = msg.MultiDOFJointState(
            msg.Header(frame_id=robot.base.frame), [robot.base.name], [transform]
        )
    return msg.RobotState(
        joint_state=msg.JointState(name=list(named), position=list(named.values())),
        multi_dof_joint_state=several,
        attached_collision_objects=list(attached_messages(scene).values()),
    )


def scene_message(scene: Scene, positions: Floats, components: int) -> msg.PlanningScene:
    """Return the requested components of a scene as a message.

    Args:
        positions: Of all joints, shape (number of joints,) [rad | m].
        components: A sum of constants of `PlanningSceneComponents`.
    """
    asked, message = msg.PlanningSceneComponents, msg.PlanningScene(robot_model_name=scene.robot.name)
    frame = scene.robot.links[0]
    if components & (asked.ROBOT_STATE | asked.ROBOT_STATE_ATTACHED_OBJECTS):
        message.robot_state = state_message(scene, positions)
        if not components & asked.ROBOT_STATE_ATTACHED_OBJECTS:
            message.robot_state.attached_collision_objects = []
    if components & (asked.WORLD_OBJECT_NAMES | asked.WORLD_OBJECT_GEOMETRY):
        objects = world_messages(scene, frame)
        if not components & asked.WORLD_OBJECT_GEOMETRY:
            objects = {name: msg.CollisionObject(id=name) for name in objects}
        message.world = msg.PlanningSceneWorld(list(objects.values()))
    if components & asked.TRANSFORMS:
        message.fixed_frame_transforms = _fixed_frames(scene, frame)
    if components & asked.ALLOWED_COLLISION_MATRIX:
        message.allowed_collision_matrix = matrix_message(scene)
    if components & asked.LINK_PADDING_AND_SCALING:
        message.link_padding = [msg.LinkPadding(*item) for item in scene.clearances.links.items()]
        scales = {body.owner: body.scale for body in scene.robot.bodies if body.scale != 1.0}
        message.link_scale = [msg.LinkScale(*item) for item in scales.items()]
    return message


def _fixed_frames(scene: Scene, frame: str) -> list[msg.TransformStamped]:
    """Return the frames without a shape: fixed world frames and tool frames."""
    standing = [name for name, item in scene.objects.items() if not item.parts and item.frame == WORLD]
    placed = [(frame, name, scene.object(name).placement) for name in standing]
    placed += [(item.frame, name, item.placement) for name, item in scene.tools.items()]
    return [
        msg.TransformStamped(msg.Header(frame_id=on), name, transform_of(where)) for on, name, where in placed
    ]


@checked
def write_scene(path: Path | str, scene: Scene, positions: Floats) -> None:
    """Write a scene as `moveit_msgs/PlanningScene`: JSON if the file name ends in .json, else YAML.

    This message cannot represent margins, clearances by kind or by name, temporary allowed contacts and
    motions; a bundle can (`result.save`).

    Args:
        positions: Of all joints, shape (number of joints,) [rad | m].

    Raises:
        FileFormatError: If the file cannot be written.
        ShapeError: If there is not one finite position for each joint.
    """
    at = floats("positions", positions, (len(one_of("scene", scene, Scene).robot.joint_names),))
    message = document_of(scene_message(scene, at, WRITTEN), "scene")
    write_message(path, cast("dict[str, object]", message.value))
