"""What frame ids mean while one of MoveIt's files is read."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from trajopt.robot.loading.pinocchio_model import root_placement
from trajopt.robot.mesh_cover import MeshPolicy
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node
from trajopt.values.errors import FrameNotFound, NameNotFound
from trajopt.values.placement import IDENTITY, WORLD, Placement

HEADER_FIELDS = ("seq", "stamp", "frame_id")


@dataclass(frozen=True, eq=False)
class Reading:
    """What names and frames mean while a file is read, and what there is to say about it.

    Attributes:
        world_names: Frame ids that mean the world.
        positions: Of all joints, where a frame of the robot is meant as it stands in the file.
        meshes: How meshes become convex.
        notes: Sentences on what was taken differently from how it is written.
    """

    world_names: frozenset[str]
    positions: Floats
    meshes: MeshPolicy | None = None
    notes: list[str] = field(default_factory=list[str])


def world_names(robot: Robot) -> frozenset[str]:
    """Return the frame ids that mean the world for every file.

    None, "world", the SRDF's name for it, and the root link unless the robot stands elsewhere.
    """
    root = (robot.links[0],) if root_placement(robot.model) == IDENTITY else ()
    return frozenset(("", WORLD, robot.base.frame, *root))


def frame_id(node: Node) -> str:
    """Return the frame id of a header, without the slash in front that old files have."""
    return node.only(HEADER_FIELDS)["frame_id"].text("").removeprefix("/")


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
    """Return where a frame is in the world while the robot stands as the file says."""
    return scene.placement_of(frame, reading.positions)


def require(node: Node, error: type[NameNotFound], kind: str, name: str, known: Iterable[str]) -> None:
    """Make sure that a name is known.

    Raises:
        NameNotFound: Of the given class, naming the place in the file and what comes near.
    """
    names = tuple(known)
    if name not in names:
        raise error(f"{kind} (at {node.place} in {node.path})", name, names)
