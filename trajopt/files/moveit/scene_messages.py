"""Scenes and robot states as messages, robot states read from them, and planning scenes as files."""

from collections.abc import Mapping
from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path
from typing import cast

from trajopt.files import messages as msg
from trajopt.files.messages import JointState, MultiDOFJointState, RobotState, document_of, field_names
from trajopt.files.moveit.frames import frame_id, pose_of, read_placement, read_vector, require, transform_of
from trajopt.files.moveit.trajectories import in_the_plane, planar_joints, planar_placement, write_message
from trajopt.problem.requirements import Requirement, joint_positions
from trajopt.robot.bases import PLANAR
from trajopt.robot.loading.pinocchio_model import placed_model, root_placement
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import SceneObject
from trajopt.values.arrays import Floats, floats, one_of
from trajopt.values.documents.document import Node
from trajopt.values.errors import JointNotFound, listed, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import IDENTITY, WORLD, Placement, placement
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
    """Return the world objects, by id, in the planning frame."""
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
    allowed = scene.allowed
    rows = [msg.AllowedCollisionEntry([a != b and allowed.allowed(a, b) for b in names]) for a in names]
    defaults = allowed.defaults
    return msg.AllowedCollisionMatrix(names, rows, list(defaults), list(defaults.values()))


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
    """Return the requested components of a scene as a message."""
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
    standing = [name for name, item in scene.objects.items() if not item.parts and item.frame == WORLD]
    placed = [(frame, name, scene.object(name).placement) for name in standing]
    placed += [(item.frame, name, item.placement) for name, item in scene.tools.items()]
    return [
        msg.TransformStamped(msg.Header(frame_id=on), name, transform_of(where)) for on, name, where in placed
    ]


@checked
def write_scene(path: Path | str, scene: Scene, positions: Floats) -> None:
    """Write a scene as `moveit_msgs/PlanningScene`: JSON if the file name ends in .json, else YAML.

    It loses margins, clearances by kind or name, temporary contacts and motions; a bundle does not
    (`result.save`).

    Raises:
        FileFormatError: If the file cannot be written.
        ShapeError: If there is not one finite position for each joint.
    """
    at = floats("positions", positions, (len(one_of("scene", scene, Scene).robot.joint_names),))
    message = document_of(scene_message(scene, at, WRITTEN), "scene")
    write_message(path, cast("dict[str, object]", message.value))


NOT_DISPLACED = 1e-6
"""Largest deviation of a listed fixed joint from its fixed pose [m | rad]."""
FIXED_JOINT_TOLERANCE = 1e-6
"""A fixed joint may be listed with a position this close to zero [rad | m]."""


def base_positions(node: Node, robot: Robot, notes: list[str]) -> Mapping[str, float]:
    """Return the positions of a planar base, by joint [rad | m]; empty for other bases."""
    positions: dict[str, float] = {}
    for joint, transform in _transforms(node, robot):
        if joint == robot.base.name and len(robot.base.joints) == len(PLANAR):
            found = in_the_plane(transform, notes)
            positions |= dict(zip(robot.base.joints, found, strict=True))
            continue
        stands = (
            root_placement(robot.model) if joint == robot.base.name and not robot.base.joints else IDENTITY
        )
        if not _same(read_placement(transform, notes), stands):
            raise transform.error(
                f"{joint or 'the base'} of {robot.name} cannot be elsewhere than at {stands}"
            )
    return positions


def placed_robot(node: Node, robot: Robot, notes: list[str]) -> Robot:
    """Return the robot with its fixed base at the pose of a robot state, and note a change."""
    if robot.base.joints:
        return robot
    for joint, transform in _transforms(node, robot):
        where, now = read_placement(transform, []), root_placement(robot.model)
        if joint == robot.base.name and not _same(where, now):
            notes.append(f"{transform.place}: {robot.name}, whose base is fixed, is placed at {where}")
            return replace(robot, model=placed_model(robot.model, where * now.inverse()))
    return robot


def read_workspace(
    node: Node, robot: Robot, group: str, world_names: frozenset[str], notes: list[str]
) -> tuple[Requirement, ...]:
    """Return the requirement of a workspace: a planar base stays inside; arms are not restricted.

    A box of zero size or in another frame is ignored.
    """
    moved = robot.base.joints[:2] if len(robot.base.joints) == len(PLANAR) else ()
    corners = [read_vector(node[key]) for key in ("min_corner", "max_corner")]
    if (
        not moved
        or not set(moved) <= set(robot.group(group).joints)
        or not any(map(any, filter(None, corners)))
    ):
        return ()
    if frame_id(node["header"]) not in world_names:
        notes.append(f"{node.place}: is ignored, being of a frame that is not the world")
        return ()
    low, high = (corner or (0.0, 0.0, 0.0) for corner in corners)
    if low[0] > high[0] or low[1] > high[1]:
        raise node.error("its least corner is beyond its largest one")
    middle = {joint: (low[i] + high[i]) / 2.0 for i, joint in enumerate(moved)}
    half = {joint: (high[i] - low[i]) / 2.0 for i, joint in enumerate(moved)}
    return (joint_positions(middle, below=half, above=half),)


def _transforms(node: Node, robot: Robot) -> list[tuple[str, Node]]:
    node.only(field_names(MultiDOFJointState))
    names = [name.text() for name in node["joint_names"].elements()]
    transforms = node["transforms"].elements()
    if names and len(names) != len(transforms):
        raise node.error(f"{len(names)} names, but {len(transforms)} transforms")
    if len(transforms) == 1 and (not names or not robot.base.name):
        names = [robot.base.name]
    return list(zip(names or [""] * len(transforms), transforms, strict=True))


def _same(one: Placement, other: Placement) -> bool:
    return float(abs(one.homogeneous - other.homogeneous).max()) <= NOT_DISPLACED


def read_joint_positions(node: Node, robot: Robot, notes: list[str]) -> Mapping[str, float]:
    """Return the joint positions in a robot state, by joint [rad | m].

    Joints that the description fixes or does not have, such as wheels and fingers, are skipped and noted. The
    positions of a planar base come from its transform; see `base_positions`.
    """
    stated, place = _stated(node), node["joint_state"].place
    unknown = [joint for joint in stated if joint not in (*robot.joint_names, *robot.fixed_joints)]
    if unknown:
        free = [joint for joint in robot.joint_names if joint not in stated]
        named = listed([joint + _near(joint, free) for joint in unknown])
        notes.append(f"{place}: left out, being no joints of {robot.name}: {named}")
    fixed = [f"{joint} (at {at:g})" for joint, (at, *_) in stated.items() if _moved(robot, joint, at)]
    if fixed:
        notes.append(f"{place}: left out, being fixed in {robot.name}: {listed(fixed)}")
    base = base_positions(node["multi_dof_joint_state"], robot, notes)
    return {**{joint: at for joint, (at, *_) in stated.items() if joint in robot.joint_names}, **base}


def checked_joint_positions(node: Node, robot: Robot) -> Mapping[str, float]:
    """Return the joint positions in a robot state that may name only joints of the robot."""
    for joint, (at, name, value) in _stated(node).items():
        if _moved(robot, joint, at):
            raise value.error(f"joint {shown(joint)} is fixed and cannot be at {at:g}")
        if joint not in robot.fixed_joints:
            require(name, JointNotFound, "joint", joint, robot.joint_names)
    return read_joint_positions(node, robot, [])


def _stated(node: Node) -> Mapping[str, tuple[float, Node, Node]]:
    state = node.only(field_names(RobotState))["joint_state"]
    state.only(field_names(JointState))
    names, values = state["name"].elements(), state["position"].elements()
    if len(names) != len(values):
        raise state.error(f"{len(names)} names, but {len(values)} positions")
    stated: dict[str, tuple[float, Node, Node]] = {}
    for name, value in zip(names, values, strict=True):
        joint, position = name.text(), value.number()
        if stated.setdefault(joint, (position, name, value))[0] != position:
            raise name.error(f"joint {shown(joint)} is listed twice, at different positions")
    return stated


def _moved(robot: Robot, joint: str, position: float) -> bool:
    return joint in robot.fixed_joints and abs(position) > FIXED_JOINT_TOLERANCE


def _near(joint: str, free: list[str]) -> str:
    near = get_close_matches(joint, free, n=1)
    return f" (did you mean {shown(near[0])}?)" if near else ""


def layered_positions(robot: Robot, *layers: Mapping[str, float]) -> Floats:
    """Return positions of all joints, (number of joints,) [rad | m]; later layers override earlier ones.

    If a later layer moves the source of a mimic joint, the joint follows its source, unless that layer or a
    later one names the joint itself. Joints in no layer have their default.
    """
    named: dict[str, float] = {}
    for layer in layers:
        for joint, mimic in robot.mimics.items():
            if mimic.source in layer:
                named.pop(joint, None)
        named.update(layer)
    return robot.positions(named)
