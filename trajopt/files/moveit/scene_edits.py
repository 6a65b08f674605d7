"""Apply messages to an existing scene: whole scenes, scene differences and objects."""

from dataclasses import replace

from trajopt.files.moveit.attached_object import apply_attached
from trajopt.files.moveit.collision_matrix import apply_matrix
from trajopt.files.moveit.collision_object import apply_object, read_object, without
from trajopt.files.moveit.frames import Reading
from trajopt.files.moveit.planning_scene import SCENE_FIELDS, refuse_octomap, with_fixed_frame, with_padding
from trajopt.files.moveit.scene_messages import attached_messages
from trajopt.scene.clearances import AllowedCollisions, Clearances
from trajopt.scene.scene import Scene
from trajopt.values.documents.document import Node


def edit_object(node: Node, scene: Scene, reading: Reading) -> Scene:
    """Return the scene after a collision object message.

    Args:
        node: The message.
        scene: The scene.
        reading: Meaning of names; its positions are the current configuration.

    Raises:
        FileFormatError: If the message is malformed, or cannot be applied.
        NameNotFound: If it names an unknown frame, or moves an unknown object.
    """
    return apply_object(read_object(node, reading), scene, reading)


def edit_scene(node: Node, scene: Scene, reading: Reading) -> Scene:
    """Return the scene after a planning scene message: changed if it `is_diff`, else replaced.

    The robot and its base pose are unchanged.

    Args:
        node: The message.
        scene: The scene.
        reading: Meaning of names; its positions are the configuration of the robot, from the message if
            given.

    Raises:
        FileFormatError: If the message is malformed, cannot be applied, or contains an octomap.
        NameNotFound: If it names an unknown link, frame or object.
    """
    node.only(SCENE_FIELDS)
    if not node["is_diff"].flag():
        scene = _empty(scene)
    elif _says_all(node["robot_state"]):
        scene = _let_go(scene)
    for element in node["fixed_frame_transforms"].elements():
        scene = with_fixed_frame(element, scene, reading, again=True)
    world = node["world"].only(("collision_objects", "octomap"))
    refuse_octomap(world["octomap"])
    for element in world["collision_objects"].elements():
        scene = edit_object(element, scene, reading)
    for element in node["robot_state"]["attached_collision_objects"].elements():
        scene = apply_attached(element, scene, reading)
    scene = apply_matrix(node["allowed_collision_matrix"], scene, reading.notes)
    return with_padding(node, scene, reading.notes)


def _says_all(state: Node) -> bool:
    """Return whether the message has a complete robot state, which then lists all attached objects."""
    told = (
        state["joint_state"]["name"],
        state["multi_dof_joint_state"]["transforms"],
        state["attached_collision_objects"],
    )
    return not state["is_diff"].flag() and any(each.elements() for each in told)


def _let_go(scene: Scene) -> Scene:
    for name in attached_messages(scene):
        scene = without(scene, name)
    return scene


def _empty(scene: Scene) -> Scene:
    """Return a scene with the unscaled robot, its tools, margins and general clearances."""
    everywhere = Clearances(scene.clearances.everywhere, kinds=scene.clearances.kinds)
    robot = scene.robot
    if any(body.scale != 1.0 for body in robot.bodies):
        robot = replace(robot, bodies=tuple(body.scaled(1.0) for body in robot.bodies))
    return Scene(
        robot,
        margin=scene.margin,
        kind_margins=scene.kind_margins,
        clearances=everywhere,
        tools=scene.tools_on_links,
    )


def without_collisions(scene: Scene) -> Scene:
    """Return the scene with every contact allowed."""
    everything = dict.fromkeys((*scene.robot.links, *scene.objects), True)
    return replace(scene, allowed=AllowedCollisions({}, everything))
