"""Messages of `visualization_msgs`: markers that show a robot."""

from dataclasses import dataclass, field
from typing import ClassVar

from trajopt.files.messages.geometry_msgs import Pose, Vector3
from trajopt.files.messages.std_msgs import ColorRGBA, Header


@dataclass(slots=True)
class Marker:
    """A shape or mesh file at a pose."""

    CUBE: ClassVar[int] = 1
    SPHERE: ClassVar[int] = 2
    CYLINDER: ClassVar[int] = 3
    MESH_RESOURCE: ClassVar[int] = 10

    header: Header = field(default_factory=Header)
    ns: str = ""
    id: int = 0
    type: int = 0
    action: int = 0
    pose: Pose = field(default_factory=Pose)
    scale: Vector3 = field(default_factory=Vector3)
    color: ColorRGBA = field(default_factory=ColorRGBA)
    mesh_resource: str = ""


@dataclass(slots=True)
class MarkerArray:
    """Several markers."""

    markers: list[Marker] = field(default_factory=list[Marker])
