"""Constraint messages of `moveit_msgs`."""

from dataclasses import dataclass, field
from typing import ClassVar

from trajopt.files.messages.geometry_msgs import Pose, PoseStamped, Quaternion, Vector3
from trajopt.files.messages.primitives import UInt8
from trajopt.files.messages.shape_msgs import Mesh, SolidPrimitive
from trajopt.files.messages.std_msgs import Header


@dataclass(slots=True)
class JointConstraint:
    """A joint near a position [rad | m]."""

    joint_name: str = ""
    position: float = 0.0
    tolerance_above: float = 0.0
    tolerance_below: float = 0.0
    weight: float = 0.0


@dataclass(slots=True)
class BoundingVolume:
    """Shapes with their poses."""

    primitives: list[SolidPrimitive] = field(default_factory=list[SolidPrimitive])
    primitive_poses: list[Pose] = field(default_factory=list[Pose])
    meshes: list[Mesh] = field(default_factory=list[Mesh])
    mesh_poses: list[Pose] = field(default_factory=list[Pose])


@dataclass(slots=True)
class PositionConstraint:
    """A point of a link in a region."""

    header: Header = field(default_factory=Header)
    link_name: str = ""
    target_point_offset: Vector3 = field(default_factory=Vector3)
    constraint_region: BoundingVolume = field(default_factory=BoundingVolume)
    weight: float = 0.0


@dataclass(slots=True)
class OrientationConstraint:
    """The orientation of a link, with a tolerance about each axis [rad]."""

    XYZ_EULER_ANGLES: ClassVar[int] = 0
    ROTATION_VECTOR: ClassVar[int] = 1

    header: Header = field(default_factory=Header)
    orientation: Quaternion = field(default_factory=Quaternion)
    link_name: str = ""
    absolute_x_axis_tolerance: float = 0.0
    absolute_y_axis_tolerance: float = 0.0
    absolute_z_axis_tolerance: float = 0.0
    parameterization: UInt8 = 0
    weight: float = 0.0


@dataclass(slots=True)
class VisibilityConstraint:
    """A sensor sees a target."""

    SENSOR_Z: ClassVar[int] = 0
    SENSOR_Y: ClassVar[int] = 1
    SENSOR_X: ClassVar[int] = 2

    target_radius: float = 0.0
    target_pose: PoseStamped = field(default_factory=PoseStamped)
    cone_sides: int = 0
    sensor_pose: PoseStamped = field(default_factory=PoseStamped)
    max_view_angle: float = 0.0
    max_range_angle: float = 0.0
    sensor_view_direction: UInt8 = 0
    weight: float = 0.0


@dataclass(slots=True)
class Constraints:
    """Constraints that hold together."""

    name: str = ""
    joint_constraints: list[JointConstraint] = field(default_factory=list[JointConstraint])
    position_constraints: list[PositionConstraint] = field(default_factory=list[PositionConstraint])
    orientation_constraints: list[OrientationConstraint] = field(default_factory=list[OrientationConstraint])
    visibility_constraints: list[VisibilityConstraint] = field(default_factory=list[VisibilityConstraint])


@dataclass(slots=True)
class TrajectoryConstraints:
    """Constraints in order along the motion."""

    constraints: list[Constraints] = field(default_factory=list[Constraints])
