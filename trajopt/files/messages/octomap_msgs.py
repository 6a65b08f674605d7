"""Messages of `octomap_msgs`: occupied space as a tree of cubes."""

from dataclasses import dataclass, field

from trajopt.files.messages.geometry_msgs import Pose
from trajopt.files.messages.primitives import Int8
from trajopt.files.messages.std_msgs import Header


@dataclass(slots=True)
class Octomap:
    """An octree in the format of its library."""

    header: Header = field(default_factory=Header)
    binary: bool = False
    id: str = ""
    resolution: float = 0.0
    data: list[Int8] = field(default_factory=list[Int8])


@dataclass(slots=True)
class OctomapWithPose:
    """An octree and its pose."""

    header: Header = field(default_factory=Header)
    origin: Pose = field(default_factory=Pose)
    octomap: Octomap = field(default_factory=Octomap)
