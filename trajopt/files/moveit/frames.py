"""Frames and poses in MoveIt's messages and files."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from math import hypot, inf

from trajopt.files.messages import Header, Point, Pose, Quaternion, Transform, Vector3, field_names
from trajopt.robot.bodies import MeshPolicy
from trajopt.robot.loading.pinocchio_model import root_placement
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node
from trajopt.values.errors import FrameNotFound, NameNotFound, SizeError
from trajopt.values.placement import IDENTITY, WORLD, Placement, placement


@dataclass(frozen=True, eq=False)
class Reading:
    """Meaning of names and frames while reading a file, and notes on the reading.

    Attributes:
        world_names: Frame ids of the world.
        positions: Of all joints; frames of the robot are taken at this configuration.
    """

    world_names: frozenset[str]
    positions: Floats
    meshes: MeshPolicy | None = None
    notes: list[str] = field(default_factory=list[str])


def world_names(robot: Robot) -> frozenset[str]:
    """Return the frame ids that mean the world in every file.

    These are None, "world", the world frame of the SRDF, and the root link if the robot is at the origin.
    """
    root = robot.links[0]
    at_origin = (root, root.removeprefix("/")) if root_placement(robot.model) == IDENTITY else ()
    return frozenset(("", WORLD, robot.base.frame, *at_origin))


def frame_named(name: str, robot: Robot) -> str:
    """Return the frame of a frame id: "world" for all that mean it, and with a slash a link that has it."""
    if name in world_names(robot):
        return WORLD
    return f"/{name}" if name not in robot.frame_names and f"/{name}" in robot.frame_names else name


def reading_at(scene: Scene, positions: Floats, notes: list[str] | None = None) -> Reading:
    """Return the meaning of names and frames in a message to a scene."""
    return Reading(world_names(scene.robot), positions, notes=[] if notes is None else notes)


def frame_id(node: Node) -> str:
    return node.only(field_names(Header))["frame_id"].text("").removeprefix("/")


def read_frame(header: Node, scene: Scene, reading: Reading) -> str:
    """Return the frame that a header names: "world", a frame of the robot or an object."""
    name = frame_id(header)
    if name in reading.world_names:
        return WORLD
    name = frame_named(name, scene.robot)
    known = (*scene.frame_names, *scene.objects)
    require(header["frame_id"], FrameNotFound, "frame", name, known)
    return name


def read_frame_name(node: Node, scene: Scene) -> str:
    name = node.text()
    carried = [key for key in scene.objects if scene.holder(key).link != WORLD]
    require(node, FrameNotFound, "frame", name, (*scene.frame_names, *carried))
    return name


def placement_in_world(frame: str, scene: Scene, reading: Reading) -> Placement:
    """Return the placement of a frame in the world, at the robot state of the file."""
    return scene.placement_of(frame, reading.positions)


def require(node: Node, error: type[NameNotFound], kind: str, name: str, known: Iterable[str]) -> None:
    names = tuple(known)
    if name not in names:
        raise error(f"{kind} (at {node.place} in {node.path})", name, names)


LEAST_TOLERANCE = 1e-4
"""Tolerance used if a file gives zero or none [rad | m]."""


def read_vector(node: Node, axes: str = "xyz", optional: str = "") -> tuple[float, ...] | None:
    """Return the components of a vector, [x, y, z] or {x:, y:, z:}, 0 if optional; None if missing."""
    if node.missing:
        return None
    if isinstance(node.value, list):
        numbers = node.numbers()
        if len(numbers) != len(axes):
            raise node.error(f"needs {len(axes)} numbers ({', '.join(axes)}), has {len(numbers)}")
        return numbers
    node.only(axes)
    return tuple(node[axis].number(0.0 if axis in optional else None) for axis in axes)


def read_placement(node: Node, notes: list[str]) -> Placement:
    """Return a pose (position, orientation) or transform (translation, rotation).

    Missing components are zero; a quaternion's w, if any of x, y and z is given, is 0 in ROS 1 and 1 in ROS
    2. A quaternion of zeros is an unset message field and represents no rotation; others are normalised.

    Args:
        notes: Receives a sentence for every quaternion that was not of unit length.
    """
    if node.missing:
        return IDENTITY
    transform = node.has("translation") or node.has("rotation")
    where, how = ("translation", "rotation") if transform else ("position", "orientation")
    node.only((where, how))
    quaternion = read_quaternion(node[how], notes)
    try:
        return placement(read_vector(node[where], optional="xyz") or (0.0, 0.0, 0.0), quaternion=quaternion)
    except SizeError as error:
        raise node[where].error(str(error)) from error


def read_quaternion(node: Node, notes: list[str]) -> tuple[float, ...]:
    """Return a unit quaternion (x, y, z, w); no rotation if it is missing, empty or all zero."""
    none = (0.0, 0.0, 0.0, 1.0)
    parts = None if node.value == {} else read_vector(node, "xyzw", optional="xyz")
    if parts is None:
        return none
    length = hypot(*parts)
    if length == 0.0:
        notes.append(f"{node.place}: a quaternion of zeros, taken for no rotation")
        return none
    if not 1e-9 < length < inf:
        raise node.error(f"a quaternion of length {length:g} is not an orientation")
    if abs(length - 1.0) > 1e-3:
        notes.append(f"{node.place}: a quaternion of length {length:.6g}, normalised")
    return tuple(part / length for part in parts)


def pose_of(where: Placement) -> Pose:
    """Return a placement as a pose."""
    return Pose(Point(*where.translation.tolist()), Quaternion(*where.quaternion.tolist()))


def transform_of(where: Placement) -> Transform:
    x, y, z = where.translation.tolist()
    return Transform(Vector3(x, y, z), Quaternion(*where.quaternion.tolist()))


def read_tolerance(node: Node) -> float:
    value = node.number(0.0, infinite=True)
    if value < 0.0:
        raise node.error(f"is negative: {value:g}")
    return value or LEAST_TOLERANCE
