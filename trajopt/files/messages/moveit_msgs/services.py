"""Requests and responses of MoveIt's services."""

from dataclasses import dataclass, field

from trajopt.files.messages.geometry_msgs import Pose, PoseStamped
from trajopt.files.messages.moveit_msgs.constraints import Constraints
from trajopt.files.messages.moveit_msgs.error_codes import MoveItErrorCodes
from trajopt.files.messages.moveit_msgs.kinematics import (
    ConstraintEvalResult,
    ContactInformation,
    CostSource,
    PositionIKRequest,
)
from trajopt.files.messages.moveit_msgs.planning import (
    MotionPlanRequest,
    MotionPlanResponse,
    PlannerInterfaceDescription,
    RobotTrajectory,
)
from trajopt.files.messages.moveit_msgs.planning_scene import (
    PlanningScene,
    PlanningSceneComponents,
    RobotState,
)
from trajopt.files.messages.std_msgs import Header


@dataclass(slots=True)
class GetPositionFKRequest:
    """Request of link poses in a state; all links if none is named."""

    header: Header = field(default_factory=Header)
    fk_link_names: list[str] = field(default_factory=list[str])
    robot_state: RobotState = field(default_factory=RobotState)


@dataclass(slots=True)
class GetPositionFKResponse:
    """Link poses, in the frame of the request's header."""

    pose_stamped: list[PoseStamped] = field(default_factory=list[PoseStamped])
    fk_link_names: list[str] = field(default_factory=list[str])
    error_code: MoveItErrorCodes = field(default_factory=MoveItErrorCodes)


@dataclass(slots=True)
class GetPositionIKRequest:
    """Request of a state with given link poses."""

    ik_request: PositionIKRequest = field(default_factory=PositionIKRequest)


@dataclass(slots=True)
class GetPositionIKResponse:
    """The state."""

    solution: RobotState = field(default_factory=RobotState)
    error_code: MoveItErrorCodes = field(default_factory=MoveItErrorCodes)


@dataclass(slots=True)
class GetMotionPlanRequest:
    """A motion to a goal."""

    motion_plan_request: MotionPlanRequest = field(default_factory=MotionPlanRequest)


@dataclass(slots=True)
class GetMotionPlanResponse:
    """The motion."""

    motion_plan_response: MotionPlanResponse = field(default_factory=MotionPlanResponse)


@dataclass(slots=True)
class GetCartesianPathRequest:
    """Request of a link motion on straight lines through poses."""

    header: Header = field(default_factory=Header)
    start_state: RobotState = field(default_factory=RobotState)
    group_name: str = ""
    link_name: str = ""
    waypoints: list[Pose] = field(default_factory=list[Pose])
    max_step: float = 0.0
    jump_threshold: float = 0.0
    prismatic_jump_threshold: float = 0.0
    revolute_jump_threshold: float = 0.0
    avoid_collisions: bool = False
    path_constraints: Constraints = field(default_factory=Constraints)
    max_velocity_scaling_factor: float = 0.0
    max_acceleration_scaling_factor: float = 0.0
    cartesian_speed_limited_link: str = ""
    cartesian_speed_end_effector_link: str = ""
    max_cartesian_speed: float = 0.0


@dataclass(slots=True)
class GetCartesianPathResponse:
    """The motion, and the fraction of the path that it covers."""

    start_state: RobotState = field(default_factory=RobotState)
    solution: RobotTrajectory = field(default_factory=RobotTrajectory)
    fraction: float = 0.0
    error_code: MoveItErrorCodes = field(default_factory=MoveItErrorCodes)


@dataclass(slots=True)
class GetStateValidityRequest:
    """Request to check a state for contacts and constraints."""

    robot_state: RobotState = field(default_factory=RobotState)
    group_name: str = ""
    constraints: Constraints = field(default_factory=Constraints)


@dataclass(slots=True)
class GetStateValidityResponse:
    """Whether the state is valid, and its contacts."""

    valid: bool = False
    contacts: list[ContactInformation] = field(default_factory=list[ContactInformation])
    cost_sources: list[CostSource] = field(default_factory=list[CostSource])
    constraint_result: list[ConstraintEvalResult] = field(default_factory=list[ConstraintEvalResult])


@dataclass(slots=True)
class GetPlanningSceneRequest:
    """Request of the scene, with the selected components."""

    components: PlanningSceneComponents = field(default_factory=PlanningSceneComponents)


@dataclass(slots=True)
class GetPlanningSceneResponse:
    """The scene."""

    scene: PlanningScene = field(default_factory=PlanningScene)


@dataclass(slots=True)
class ApplyPlanningSceneRequest:
    """A scene, or a difference to it."""

    scene: PlanningScene = field(default_factory=PlanningScene)


@dataclass(slots=True)
class ApplyPlanningSceneResponse:
    """Whether the scene was applied."""

    success: bool = False


@dataclass(slots=True)
class QueryPlannerInterfacesRequest:
    """Which planners there are."""


@dataclass(slots=True)
class QueryPlannerInterfacesResponse:
    """The pipelines and their planners."""

    planner_interfaces: list[PlannerInterfaceDescription] = field(
        default_factory=list[PlannerInterfaceDescription]
    )
