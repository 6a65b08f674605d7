"""Planning messages of `moveit_msgs`: requests, trajectories, grasps."""

from dataclasses import dataclass, field

from trajopt.files.messages.builtin_interfaces import Duration
from trajopt.files.messages.geometry_msgs import Accel, Pose, PoseStamped, Twist, Vector3, Vector3Stamped
from trajopt.files.messages.moveit_msgs.constraints import Constraints, TrajectoryConstraints
from trajopt.files.messages.moveit_msgs.error_codes import MoveItErrorCodes
from trajopt.files.messages.moveit_msgs.planning_scene import ObjectColor, RobotState
from trajopt.files.messages.primitives import Float32
from trajopt.files.messages.std_msgs import Header
from trajopt.files.messages.trajectory_msgs import JointTrajectory, MultiDOFJointTrajectory


@dataclass(slots=True)
class RobotTrajectory:
    """The trajectory of a group's joints, for execution."""

    joint_trajectory: JointTrajectory = field(default_factory=JointTrajectory)
    multi_dof_joint_trajectory: MultiDOFJointTrajectory = field(default_factory=MultiDOFJointTrajectory)


@dataclass(slots=True)
class CartesianPoint:
    """Pose, velocity and acceleration of a link."""

    pose: Pose = field(default_factory=Pose)
    velocity: Twist = field(default_factory=Twist)
    acceleration: Accel = field(default_factory=Accel)


@dataclass(slots=True)
class CartesianTrajectoryPoint:
    """State of a link at a time."""

    point: CartesianPoint = field(default_factory=CartesianPoint)
    time_from_start: Duration = field(default_factory=Duration)


@dataclass(slots=True)
class CartesianTrajectory:
    """Points over time, of a link."""

    header: Header = field(default_factory=Header)
    tracked_frame: str = ""
    points: list[CartesianTrajectoryPoint] = field(default_factory=list[CartesianTrajectoryPoint])


@dataclass(slots=True)
class GenericTrajectory:
    """Trajectories of joints and of links; trajopt does not plan along them."""

    header: Header = field(default_factory=Header)
    joint_trajectory: list[JointTrajectory] = field(default_factory=list[JointTrajectory])
    cartesian_trajectory: list[CartesianTrajectory] = field(default_factory=list[CartesianTrajectory])


@dataclass(slots=True)
class DisplayTrajectory:
    """A sequence of trajectories for display."""

    model_id: str = ""
    trajectory: list[RobotTrajectory] = field(default_factory=list[RobotTrajectory])
    trajectory_start: RobotState = field(default_factory=RobotState)


@dataclass(slots=True)
class DisplayRobotState:
    """A state, to be looked at."""

    state: RobotState = field(default_factory=RobotState)
    highlight_links: list[ObjectColor] = field(default_factory=list[ObjectColor])
    hide: bool = False


@dataclass(slots=True)
class WorkspaceParameters:
    """A box around the robot [m]."""

    header: Header = field(default_factory=Header)
    min_corner: Vector3 = field(default_factory=Vector3)
    max_corner: Vector3 = field(default_factory=Vector3)


@dataclass(slots=True)
class MotionPlanRequest:
    """A planning problem."""

    workspace_parameters: WorkspaceParameters = field(default_factory=WorkspaceParameters)
    start_state: RobotState = field(default_factory=RobotState)
    goal_constraints: list[Constraints] = field(default_factory=list[Constraints])
    path_constraints: Constraints = field(default_factory=Constraints)
    trajectory_constraints: TrajectoryConstraints = field(default_factory=TrajectoryConstraints)
    reference_trajectories: list[GenericTrajectory] = field(default_factory=list[GenericTrajectory])
    pipeline_id: str = ""
    planner_id: str = ""
    group_name: str = ""
    num_planning_attempts: int = 0
    allowed_planning_time: float = 0.0
    max_velocity_scaling_factor: float = 0.0
    max_acceleration_scaling_factor: float = 0.0
    cartesian_speed_limited_link: str = ""
    max_cartesian_speed: float = 0.0
    cartesian_speed_end_effector_link: str = ""


@dataclass(slots=True)
class MotionPlanResponse:
    """How planning ended, and the motion."""

    trajectory_start: RobotState = field(default_factory=RobotState)
    group_name: str = ""
    trajectory: RobotTrajectory = field(default_factory=RobotTrajectory)
    planning_time: float = 0.0
    error_code: MoveItErrorCodes = field(default_factory=MoveItErrorCodes)


@dataclass(slots=True)
class PlannerInterfaceDescription:
    """Names of a pipeline and its planners."""

    name: str = ""
    pipeline_id: str = ""
    planner_ids: list[str] = field(default_factory=list[str])


@dataclass(slots=True)
class GripperTranslation:
    """A straight motion of the hand along a direction."""

    direction: Vector3Stamped = field(default_factory=Vector3Stamped)
    desired_distance: Float32 = 0.0
    min_distance: Float32 = 0.0


@dataclass(slots=True)
class Grasp:
    """A grasp of an object: hand pose, approach and retreat."""

    id: str = ""
    pre_grasp_posture: JointTrajectory = field(default_factory=JointTrajectory)
    grasp_posture: JointTrajectory = field(default_factory=JointTrajectory)
    grasp_pose: PoseStamped = field(default_factory=PoseStamped)
    grasp_quality: float = 0.0
    pre_grasp_approach: GripperTranslation = field(default_factory=GripperTranslation)
    post_grasp_retreat: GripperTranslation = field(default_factory=GripperTranslation)
    post_place_retreat: GripperTranslation = field(default_factory=GripperTranslation)
    max_contact_force: Float32 = 0.0
    allowed_touch_objects: list[str] = field(default_factory=list[str])


@dataclass(slots=True)
class PlaceLocation:
    """A place for an object: its pose, and the hand's approach and retreat."""

    id: str = ""
    post_place_posture: JointTrajectory = field(default_factory=JointTrajectory)
    place_pose: PoseStamped = field(default_factory=PoseStamped)
    quality: float = 0.0
    pre_place_approach: GripperTranslation = field(default_factory=GripperTranslation)
    post_place_retreat: GripperTranslation = field(default_factory=GripperTranslation)
    allowed_touch_objects: list[str] = field(default_factory=list[str])
