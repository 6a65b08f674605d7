"""Scene messages of `moveit_msgs`: objects, allowed contacts and the robot state."""

from dataclasses import dataclass, field
from typing import ClassVar

from trajopt.files.messages.geometry_msgs import Pose, TransformStamped
from trajopt.files.messages.object_recognition_msgs import ObjectType
from trajopt.files.messages.octomap_msgs import OctomapWithPose
from trajopt.files.messages.primitives import Int8, UInt32
from trajopt.files.messages.sensor_msgs import JointState, MultiDOFJointState
from trajopt.files.messages.shape_msgs import Mesh, Plane, SolidPrimitive
from trajopt.files.messages.std_msgs import ColorRGBA, Header
from trajopt.files.messages.trajectory_msgs import JointTrajectory


@dataclass(slots=True)
class CollisionObject:
    """An object and the operation on it."""

    ADD: ClassVar[int] = 0
    REMOVE: ClassVar[int] = 1
    APPEND: ClassVar[int] = 2
    MOVE: ClassVar[int] = 3

    header: Header = field(default_factory=Header)
    pose: Pose = field(default_factory=Pose)
    id: str = ""
    type: ObjectType = field(default_factory=ObjectType)
    primitives: list[SolidPrimitive] = field(default_factory=list[SolidPrimitive])
    primitive_poses: list[Pose] = field(default_factory=list[Pose])
    meshes: list[Mesh] = field(default_factory=list[Mesh])
    mesh_poses: list[Pose] = field(default_factory=list[Pose])
    planes: list[Plane] = field(default_factory=list[Plane])
    plane_poses: list[Pose] = field(default_factory=list[Pose])
    subframe_names: list[str] = field(default_factory=list[str])
    subframe_poses: list[Pose] = field(default_factory=list[Pose])
    operation: Int8 = 0


@dataclass(slots=True)
class AttachedCollisionObject:
    """An object that a link carries."""

    link_name: str = ""
    object: CollisionObject = field(default_factory=CollisionObject)
    touch_links: list[str] = field(default_factory=list[str])
    detach_posture: JointTrajectory = field(default_factory=JointTrajectory)
    weight: float = 0.0


@dataclass(slots=True)
class RobotState:
    """Joint positions and attached objects."""

    joint_state: JointState = field(default_factory=JointState)
    multi_dof_joint_state: MultiDOFJointState = field(default_factory=MultiDOFJointState)
    attached_collision_objects: list[AttachedCollisionObject] = field(
        default_factory=list[AttachedCollisionObject]
    )
    is_diff: bool = False


@dataclass(slots=True)
class AllowedCollisionEntry:
    """One row of the matrix."""

    enabled: list[bool] = field(default_factory=list[bool])


@dataclass(slots=True)
class AllowedCollisionMatrix:
    """Which links and objects may touch."""

    entry_names: list[str] = field(default_factory=list[str])
    entry_values: list[AllowedCollisionEntry] = field(default_factory=list[AllowedCollisionEntry])
    default_entry_names: list[str] = field(default_factory=list[str])
    default_entry_values: list[bool] = field(default_factory=list[bool])

    def set_default(self, obj: str, allow: bool) -> None:
        """Allow or forbid all contacts of a link or object by default."""
        if obj in self.default_entry_names:
            self.default_entry_values[self.default_entry_names.index(obj)] = allow
        else:
            self.default_entry_names.append(obj)
            self.default_entry_values.append(allow)

    def set_allowed(self, obj: str, other: str | None = None, allow: bool = True) -> None:
        """Allow or forbid contact of a pair, or of one with everything (`other` None)."""
        if other is None:
            self.set_default(obj, allow)
            return
        for name in (obj, other):
            if name not in self.entry_names:
                self.entry_names.append(name)
                for row in self.entry_values:
                    row.enabled.append(False)
                self.entry_values.append(AllowedCollisionEntry([False] * len(self.entry_names)))
        first, second = self.entry_names.index(obj), self.entry_names.index(other)
        self.entry_values[first].enabled[second] = allow
        self.entry_values[second].enabled[first] = allow


@dataclass(slots=True)
class LinkPadding:
    """Clearance that a link must keep from the objects of the world [m]."""

    link_name: str = ""
    padding: float = 0.0


@dataclass(slots=True)
class LinkScale:
    """Scale of a link's collision shapes."""

    link_name: str = ""
    scale: float = 1.0


@dataclass(slots=True)
class ObjectColor:
    """The colour of an object."""

    id: str = ""
    color: ColorRGBA = field(default_factory=ColorRGBA)


@dataclass(slots=True)
class PlanningSceneWorld:
    """The objects around the robot."""

    collision_objects: list[CollisionObject] = field(default_factory=list[CollisionObject])
    octomap: OctomapWithPose = field(default_factory=OctomapWithPose)


@dataclass(slots=True)
class PlanningSceneComponents:
    """The requested parts of a scene: a sum of the constants."""

    SCENE_SETTINGS: ClassVar[int] = 1
    ROBOT_STATE: ClassVar[int] = 2
    ROBOT_STATE_ATTACHED_OBJECTS: ClassVar[int] = 4
    WORLD_OBJECT_NAMES: ClassVar[int] = 8
    WORLD_OBJECT_GEOMETRY: ClassVar[int] = 16
    OCTOMAP: ClassVar[int] = 32
    TRANSFORMS: ClassVar[int] = 64
    ALLOWED_COLLISION_MATRIX: ClassVar[int] = 128
    LINK_PADDING_AND_SCALING: ClassVar[int] = 256
    OBJECT_COLORS: ClassVar[int] = 512

    components: UInt32 = 0


@dataclass(slots=True)
class PlanningScene:
    """A robot among objects; if `is_diff`, a change of the current scene."""

    name: str = ""
    robot_state: RobotState = field(default_factory=RobotState)
    robot_model_name: str = ""
    fixed_frame_transforms: list[TransformStamped] = field(default_factory=list[TransformStamped])
    allowed_collision_matrix: AllowedCollisionMatrix = field(default_factory=AllowedCollisionMatrix)
    link_padding: list[LinkPadding] = field(default_factory=list[LinkPadding])
    link_scale: list[LinkScale] = field(default_factory=list[LinkScale])
    object_colors: list[ObjectColor] = field(default_factory=list[ObjectColor])
    world: PlanningSceneWorld = field(default_factory=PlanningSceneWorld)
    is_diff: bool = False
