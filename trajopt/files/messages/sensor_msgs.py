"""Messages of `sensor_msgs`: joint states and point clouds."""

from dataclasses import dataclass, field
from typing import ClassVar

from trajopt.files.messages.geometry_msgs import Transform, Twist, Wrench
from trajopt.files.messages.primitives import Bytes, UInt8, UInt32
from trajopt.files.messages.std_msgs import Header


@dataclass(slots=True)
class JointState:
    """Positions [rad | m], velocities and efforts of joints by name."""

    header: Header = field(default_factory=Header)
    name: list[str] = field(default_factory=list[str])
    position: list[float] = field(default_factory=list[float])
    velocity: list[float] = field(default_factory=list[float])
    effort: list[float] = field(default_factory=list[float])


@dataclass(slots=True)
class MultiDOFJointState:
    """Transforms of joints of several degrees of freedom, such as a planar base."""

    header: Header = field(default_factory=Header)
    joint_names: list[str] = field(default_factory=list[str])
    transforms: list[Transform] = field(default_factory=list[Transform])
    twist: list[Twist] = field(default_factory=list[Twist])
    wrench: list[Wrench] = field(default_factory=list[Wrench])


@dataclass(slots=True)
class PointField:
    """Name, type and byte offset of a field of a point."""

    INT8: ClassVar[int] = 1
    UINT8: ClassVar[int] = 2
    INT16: ClassVar[int] = 3
    UINT16: ClassVar[int] = 4
    INT32: ClassVar[int] = 5
    UINT32: ClassVar[int] = 6
    FLOAT32: ClassVar[int] = 7
    FLOAT64: ClassVar[int] = 8

    name: str = ""
    offset: UInt32 = 0
    datatype: UInt8 = 0
    count: UInt32 = 0


@dataclass(slots=True)
class PointCloud2:
    """Points measured by a sensor, row by row."""

    header: Header = field(default_factory=Header)
    height: UInt32 = 0
    width: UInt32 = 0
    fields: list[PointField] = field(default_factory=list[PointField])
    is_bigendian: bool = False
    point_step: UInt32 = 0
    row_step: UInt32 = 0
    data: Bytes = b""
    is_dense: bool = False
