"""Attached collision object messages: objects attached to a link."""

from dataclasses import replace

from trajopt.files.moveit.collision_object import ObjectMessage, add, append, read_object
from trajopt.files.moveit.frames import Reading, placement_in_world, read_frame, require
from trajopt.scene.scene import Scene
from trajopt.values.documents.document import Node
from trajopt.values.errors import FrameNotFound, ObjectNotFound
from trajopt.values.placement import WORLD

ATTACHED_FIELDS = ("link_name", "object", "touch_links", "detach_posture", "weight")


def apply_attached(node: Node, scene: Scene, reading: Reading) -> Scene:
    """Return the scene after an attached collision object message.

    A message with shapes creates the object; without shapes, it attaches the world object of that id at its
    current pose. APPEND adds shapes to the attached object. REMOVE leaves the object in the world at its
    pose.

    Args:
        node: The message.
        scene: The scene.
        reading: Meaning of names; its positions are the configuration of attaching.

    Raises:
        FileFormatError: If the message cannot be applied.
        NameNotFound: If it names an unknown link, frame or object.
    """
    node.only(ATTACHED_FIELDS)
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
    """Return the scene with more shapes and touch links on an attached object."""
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
