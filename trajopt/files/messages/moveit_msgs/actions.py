"""Goals, results and feedback of MoveIt's actions."""

from dataclasses import dataclass, field

from trajopt.files.messages.moveit_msgs.error_codes import MoveItErrorCodes
from trajopt.files.messages.moveit_msgs.planning import MotionPlanRequest, RobotTrajectory
from trajopt.files.messages.moveit_msgs.planning_scene import PlanningScene, RobotState


@dataclass(slots=True)
class PlanningOptions:
    """Options of planning for an execution.

    MoveIt uses looking around and replanning for changing scenes; trajopt monitors the scene during
    every execution.
    """

    planning_scene_diff: PlanningScene = field(default_factory=PlanningScene)
    plan_only: bool = False
    look_around: bool = False
    look_around_attempts: int = 0
    max_safe_execution_cost: float = 0.0
    replan: bool = False
    replan_attempts: int = 0
    replan_delay: float = 0.0


@dataclass(slots=True)
class MoveGroupGoal:
    """A motion to plan and execute."""

    request: MotionPlanRequest = field(default_factory=MotionPlanRequest)
    planning_options: PlanningOptions = field(default_factory=PlanningOptions)


@dataclass(slots=True)
class MoveGroupResult:
    """The outcome and the motion."""

    error_code: MoveItErrorCodes = field(default_factory=MoveItErrorCodes)
    trajectory_start: RobotState = field(default_factory=RobotState)
    planned_trajectory: RobotTrajectory = field(default_factory=RobotTrajectory)
    executed_trajectory: RobotTrajectory = field(default_factory=RobotTrajectory)
    planning_time: float = 0.0


@dataclass(slots=True)
class MoveGroupFeedback:
    """The current activity, such as planning or moving."""

    state: str = ""


@dataclass(slots=True)
class ExecuteTrajectoryGoal:
    """A motion to execute; `controller_names` exists in ROS 2, and there is only one controller."""

    trajectory: RobotTrajectory = field(default_factory=RobotTrajectory)
    controller_names: list[str] = field(default_factory=list[str])


@dataclass(slots=True)
class ExecuteTrajectoryResult:
    """The outcome."""

    error_code: MoveItErrorCodes = field(default_factory=MoveItErrorCodes)


@dataclass(slots=True)
class ExecuteTrajectoryFeedback:
    """The current activity."""

    state: str = ""
