"""PlanningSceneInterface: edits the scene of a world, with MoveIt's API."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from trajopt.files import messages as msg
from trajopt.files.messages import document_of, is_message
from trajopt.files.moveit.frames import pose_of, reading_at
from trajopt.files.moveit.objects import apply_attached, world_objects
from trajopt.files.moveit.planning_scene import edit_object, edit_scene
from trajopt.files.moveit.scene_messages import attached_messages, mesh_message, scene_message, world_messages
from trajopt.ros.commander.conversions import framed_placement
from trajopt.ros.commander.world import World, world_or_current
from trajopt.scene.scene import Scene
from trajopt.server.move_group.outcome import speaks_moveit
from trajopt.values.documents.document import Node
from trajopt.values.errors import ObjectNotFound
from trajopt.values.shapes.mesh import load_mesh

T = TypeVar("T")
Three = Sequence[float]


@speaks_moveit
class PlanningSceneInterface:
    """Edits the scene of a world; an object replaces any of its name."""

    def __init__(self, ns: str = "", synchronous: bool = True, *, world: World | None = None) -> None:
        """Select a world, by default the one of the enclosing `with` block; edits are synchronous."""
        self._world = world_or_current(world)

    def add_object(self, collision_object: Any) -> None:
        """Apply a CollisionObject: add, remove, append or move."""
        self._apply(document_of(collision_object, "collision object"), edit_object)

    def add_sphere(self, name: str, pose: Any, radius: float = 1) -> None:
        """Add a sphere [m]."""
        self.add_object(self.make_sphere(name, pose, radius))

    def add_cylinder(self, name: str, pose: Any, height: float, radius: float) -> None:
        """Add a cylinder along z [m]."""
        self.add_object(self.make_cylinder(name, pose, height, radius))

    def add_cone(self, name: str, pose: Any, height: float, radius: float) -> None:
        """Add a cone along z [m]."""
        self.add_object(self.make_cone(name, pose, height, radius))

    def add_mesh(self, name: str, pose: Any, filename: str, size: Three = (1, 1, 1)) -> None:
        """Add the mesh of a file, scaled."""
        self.add_object(self.make_mesh(name, pose, filename, size))

    def add_box(self, name: str, pose: Any, size: Three = (1, 1, 1)) -> None:
        """Add a box [m]."""
        self.add_object(self.make_box(name, pose, size))

    def add_plane(self, name: str, pose: Any, normal: Three = (0, 0, 1), offset: float = 0) -> None:
        """Add the half-space below the plane normal * x + offset = 0, in the frame of a PoseStamped."""
        self.add_object(self.make_plane(name, pose, normal, offset))

    def attach_object(
        self, object: Any, link: str | None = None, touch_links: Sequence[str] | None = None
    ) -> None:
        """Attach an object to a link.

        Args:
            object: Name of an object of the scene, a CollisionObject, or an AttachedCollisionObject.
            link: The link; the message's link when None.
            touch_links: Links that may touch it; only the link itself when None.
        """
        if isinstance(object, str):
            self._world.scene.object(object)
            object = msg.CollisionObject(id=object)
        attached = is_message(object, "link_name", "object")
        message = object if attached else msg.AttachedCollisionObject(object=object)
        carrier = message.link_name if link is None else link
        touched = [carrier] if touch_links is None else list(touch_links)
        whole = msg.AttachedCollisionObject(carrier, message.object, touched)
        self._apply(document_of(whole, "attached object"), apply_attached)

    def process_attached(self, message: Any) -> None:
        """Apply an AttachedCollisionObject: attach or detach."""
        if message.object.operation == msg.CollisionObject.REMOVE:
            self.remove_attached_object(message.link_name or None, message.object.id or None)
        else:
            self.attach_object(message, message.link_name, message.touch_links)

    def attach_mesh(
        self,
        link: str,
        name: str,
        pose: Any = None,
        filename: str = "",
        size: Three = (1, 1, 1),
        touch_links: Sequence[str] | None = None,
    ) -> None:
        """Attach a mesh file; without a pose or a file an existing object."""
        made = self.make_mesh(name, pose, filename, size) if pose is not None and filename else name
        self.attach_object(made, link, touch_links)

    def attach_box(
        self,
        link: str,
        name: str,
        pose: Any = None,
        size: Three = (1, 1, 1),
        touch_links: Sequence[str] | None = None,
    ) -> None:
        """Attach a shape [m]; without a pose, an existing object."""
        self.attach_object(name if pose is None else self.make_box(name, pose, size), link, touch_links)

    def attach_sphere(
        self,
        link: str,
        name: str,
        pose: Any = None,
        radius: float = 1,
        touch_links: Sequence[str] | None = None,
    ) -> None:
        """Attach a shape [m]; without a pose, an existing object."""
        self.attach_object(name if pose is None else self.make_sphere(name, pose, radius), link, touch_links)

    def attach_cylinder(
        self,
        link: str,
        name: str,
        pose: Any = None,
        height: float = 1,
        radius: float = 1,
        touch_links: Sequence[str] | None = None,
    ) -> None:
        """Attach a shape [m]; without a pose, an existing object."""
        made = name if pose is None else self.make_cylinder(name, pose, height, radius)
        self.attach_object(made, link, touch_links)

    def clear(self) -> None:
        """Remove all objects, including attached ones."""
        self._world.edit(_emptied)

    def remove_world_object(self, name: str | None = None) -> None:
        """Remove an object from the world, or all objects not attached."""
        if name is not None and name not in world_objects(self._world.scene):
            raise ObjectNotFound("object in the world", name, world_objects(self._world.scene))
        self.add_object(msg.CollisionObject(id=name or "", operation=msg.CollisionObject.REMOVE))

    def remove_attached_object(self, link: str | None = None, name: str | None = None) -> None:
        """Detach one object, or all of a link or of the robot; they stay in the world."""
        if name is not None:
            self._world.scene.object(name)
        removed = msg.CollisionObject(id=name or "", operation=msg.CollisionObject.REMOVE)
        message = msg.AttachedCollisionObject(link or "", removed)
        self._apply(document_of(message, "attached object"), apply_attached)

    def get_known_object_names(self, with_type: bool = False) -> list[str]:
        """Return the names of the objects in the world; empty if `with_type`, as objects have no types."""
        return [] if with_type else list(world_messages(self._world.scene, ""))

    def get_known_object_names_in_roi(
        self,
        minx: float,
        miny: float,
        minz: float,
        maxx: float,
        maxy: float,
        maxz: float,
        with_type: bool = False,
    ) -> list[str]:
        """Return the names of objects whose shape origins are all in a box in the world [m]."""
        lower, upper = np.array((minx, miny, minz)), np.array((maxx, maxy, maxz))
        scene = self._world.scene
        found: list[str] = []
        for name in self.get_known_object_names(with_type):
            outer = scene.holder(name).placement
            origins = np.array([(outer * inner).translation for _, inner in scene.object(name).parts])
            if ((origins >= lower) & (origins <= upper)).all():
                found.append(name)
        return found

    def get_object_poses(self, object_ids: Sequence[str]) -> dict[str, msg.Pose]:
        """Return the poses of the existing objects among the names, in the planning frame."""
        objects = self.get_objects()
        return {name: objects[name].pose for name in object_ids if name in objects}

    def get_objects(self, object_ids: Sequence[str] = ()) -> dict[str, msg.CollisionObject]:
        """Return the existing objects among the names; all if no name is given."""
        return _chosen(world_messages(self._world.scene, self._world.robot.links[0]), object_ids)

    def get_attached_objects(self, object_ids: Sequence[str] = ()) -> dict[str, msg.AttachedCollisionObject]:
        """Return the attached objects among the names; all if no name is given."""
        return _chosen(attached_messages(self._world.scene), object_ids)

    def get_planning_scene(self, components: int) -> msg.PlanningScene:
        """Return the parts of the scene selected by a sum of PlanningSceneComponents constants."""
        return scene_message(self._world.scene, self._world.positions, components)

    def apply_planning_scene(self, planning_scene_message: Any) -> bool:
        """Replace the scene by a PlanningScene, or apply it as a difference.

        Joint positions in the message are ignored; the executor defines the robot's state.
        """
        self._apply(document_of(planning_scene_message, "planning scene"), edit_scene)
        return True

    @staticmethod
    def make_box(name: str, pose: Any, size: Three) -> msg.CollisionObject:
        """Return a message with a box [m]."""
        return _primitive(name, pose, msg.SolidPrimitive.BOX, size)

    @staticmethod
    def make_sphere(name: str, pose: Any, radius: float) -> msg.CollisionObject:
        """Return a message with a sphere [m]."""
        return _primitive(name, pose, msg.SolidPrimitive.SPHERE, [radius])

    @staticmethod
    def make_cylinder(name: str, pose: Any, height: float, radius: float) -> msg.CollisionObject:
        """Return a message with a cylinder [m]."""
        return _primitive(name, pose, msg.SolidPrimitive.CYLINDER, [height, radius])

    @staticmethod
    def make_cone(name: str, pose: Any, height: float, radius: float) -> msg.CollisionObject:
        """Return a message with a cone [m]."""
        return _primitive(name, pose, msg.SolidPrimitive.CONE, [height, radius])

    @staticmethod
    def make_mesh(name: str, pose: Any, filename: str, scale: Three = (1, 1, 1)) -> msg.CollisionObject:
        """Return a message with the mesh of a file."""
        x, y, z = (float(factor) for factor in scale)
        message = _placed(name, pose)
        message.meshes = [mesh_message(load_mesh(Path(filename), (x, y, z)))]
        return message

    @staticmethod
    def make_plane(name: str, pose: Any, normal: Three = (0, 0, 1), offset: float = 0) -> msg.CollisionObject:
        """Return a message with the half-space below a plane."""
        message = _placed(name, pose)
        message.planes = [msg.Plane([*map(float, normal), float(offset)])]
        return message

    def _apply(self, document: Node, change: Callable[[Node, Scene, Any], Scene]) -> None:
        positions = self._world.positions
        self._world.edit(lambda scene: change(document, scene, reading_at(scene, positions)))


def _placed(name: str, pose: Any) -> msg.CollisionObject:
    where, frame = framed_placement(pose, "")
    return msg.CollisionObject(header=msg.Header(frame_id=frame), pose=pose_of(where), id=name)


def _primitive(name: str, pose: Any, kind: int, dimensions: Three) -> msg.CollisionObject:
    message = _placed(name, pose)
    message.primitives = [msg.SolidPrimitive(kind, [float(size) for size in dimensions])]
    return message


def _chosen(objects: Mapping[str, T], names: Sequence[str]) -> dict[str, T]:
    return {name: message for name, message in objects.items() if name in names or not names}


def _emptied(scene: Scene) -> Scene:
    scene = replace(scene, tools=scene.tools_on_links)
    while scene.objects:
        frames = {item.frame for item in scene.objects.values()}
        scene = scene.remove(next(name for name in scene.objects if name not in frames))
    return scene
