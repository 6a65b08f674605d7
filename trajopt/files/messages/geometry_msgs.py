"""Messages of `geometry_msgs`: points, quaternions and poses.

As in ROS, a quaternion defaults to four zeros, which represent no rotation.
"""

from dataclasses import dataclass, field

from trajopt.files.messages.primitives import Float32
from trajopt.files.messages.std_msgs import Header


@dataclass(slots=True)
class Point:
    """A point [m]."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


@dataclass(slots=True)
class Point32:
    """A point [m] in short numbers."""

    x: Float32 = 0.0
    y: Float32 = 0.0
    z: Float32 = 0.0


@dataclass(slots=True)
class Polygon:
    """The corners in order [m]."""

    points: list[Point32] = field(default_factory=list[Point32])


@dataclass(slots=True)
class Vector3:
    """A vector."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


@dataclass(slots=True)
class Vector3Stamped:
    """A vector in a frame."""

    header: Header = field(default_factory=Header)
    vector: Vector3 = field(default_factory=Vector3)


@dataclass(slots=True)
class Quaternion:
    """An orientation."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    w: float = 0.0


@dataclass(slots=True)
class Pose:
    """Position and orientation."""

    position: Point = field(default_factory=Point)
    orientation: Quaternion = field(default_factory=Quaternion)


@dataclass(slots=True)
class PoseStamped:
    """A pose in a frame."""

    header: Header = field(default_factory=Header)
    pose: Pose = field(default_factory=Pose)


@dataclass(slots=True)
class Transform:
    """Translation and rotation."""

    translation: Vector3 = field(default_factory=Vector3)
    rotation: Quaternion = field(default_factory=Quaternion)


@dataclass(slots=True)
class TransformStamped:
    """The transform of a child frame in a frame."""

    header: Header = field(default_factory=Header)
    child_frame_id: str = ""
    transform: Transform = field(default_factory=Transform)


@dataclass(slots=True)
class Twist:
    """Velocities along [m/s] and about [rad/s] the axes."""

    linear: Vector3 = field(default_factory=Vector3)
    angular: Vector3 = field(default_factory=Vector3)


@dataclass(slots=True)
class Accel:
    """Accelerations along [m/s^2] and about [rad/s^2] the axes."""

    linear: Vector3 = field(default_factory=Vector3)
    angular: Vector3 = field(default_factory=Vector3)


@dataclass(slots=True)
class PointStamped:
    """A point in a frame."""

    header: Header = field(default_factory=Header)
    point: Point = field(default_factory=Point)


@dataclass(slots=True)
class QuaternionStamped:
    """An orientation in a frame."""

    header: Header = field(default_factory=Header)
    quaternion: Quaternion = field(default_factory=Quaternion)


@dataclass(slots=True)
class PoseArray:
    """Poses in a frame."""

    header: Header = field(default_factory=Header)
    poses: list[Pose] = field(default_factory=list[Pose])


@dataclass(slots=True)
class TwistStamped:
    """Velocities in a frame."""

    header: Header = field(default_factory=Header)
    twist: Twist = field(default_factory=Twist)


@dataclass(slots=True)
class Wrench:
    """Force [N] and torque [N m]."""

    force: Vector3 = field(default_factory=Vector3)
    torque: Vector3 = field(default_factory=Vector3)


@dataclass(slots=True)
class WrenchStamped:
    """Force and torque in a frame."""

    header: Header = field(default_factory=Header)
    wrench: Wrench = field(default_factory=Wrench)
