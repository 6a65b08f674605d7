"""Meaning of frame ids while reading a file of MoveIt."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from trajopt.files.messages import Header, field_names
from trajopt.robot.loading.pinocchio_model import root_placement
from trajopt.robot.mesh_cover import MeshPolicy
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node
from trajopt.values.errors import FrameNotFound, NameNotFound
from trajopt.values.placement import IDENTITY, WORLD, Placement


@dataclass(frozen=True, eq=False)
class Reading:
    """Meaning of names and frames while reading a file, and notes on the reading.

    Attributes:
        world_names: Frame ids of the world.
        positions: Of all joints; frames of the robot are taken at this configuration.
        meshes: Conversion of meshes to convex shapes.
        notes: Sentences on deviations from the file.
    """

    world_names: frozenset[str]
    positions: Floats
    meshes: MeshPolicy | None = None
    notes: list[str] = field(default_factory=list[str])


def world_names(robot: Robot) -> frozenset[str]:
    """Return the frame ids that mean the world in every file.

    These are None, "world", the world frame of the SRDF, and the root link if the robot is at the origin.
    """
    root = (robot.links[0],) if root_placement(robot.model) == IDENTITY else ()
    return frozenset(("", WORLD, robot.base.frame, *root))


def reading_at(scene: Scene, positions: Floats, notes: list[str] | None = None) -> Reading:
    """Return the meaning of names and frames in a message to a scene.

    Args:
        scene: The scene.
        positions: Of all joints, shape (number of joints,) [rad | m].
        notes: Receives the notes; a new list when None.
    """
    return Reading(world_names(scene.robot), positions, notes=[] if notes is None else notes)


def frame_id(node: Node) -> str:
    """Return the frame id of a header, without the leading slash of old files."""
    return node.only(field_names(Header))["frame_id"].text("").removeprefix("/")


def read_frame(header: Node, scene: Scene, reading: Reading) -> str:
    """Return the frame that a header names: "world", a frame of the robot or an object.

    Raises:
        FrameNotFound: If it is none of them.
    """
    name = frame_id(header)
    if name in reading.world_names:
        return WORLD
    known = (*scene.frame_names, *scene.objects)
    require(header["frame_id"], FrameNotFound, "frame", name, known)
    return name


def read_frame_name(node: Node, scene: Scene) -> str:
    """Return the name of a frame of the robot or of an object that a link carries.

    Raises:
        FrameNotFound: If it is neither.
    """
    name = node.text()
    carried = [key for key in scene.objects if scene.holder(key).link != WORLD]
    require(node, FrameNotFound, "frame", name, (*scene.frame_names, *carried))
    return name


def placement_in_world(frame: str, scene: Scene, reading: Reading) -> Placement:
    """Return the placement of a frame in the world, at the robot state of the file."""
    return scene.placement_of(frame, reading.positions)


def require(node: Node, error: type[NameNotFound], kind: str, name: str, known: Iterable[str]) -> None:
    """Check that a name is known.

    Raises:
        NameNotFound: Of the given class, naming the place in the file and similar names.
    """
    names = tuple(known)
    if name not in names:
        raise error(f"{kind} (at {node.place} in {node.path})", name, names)
