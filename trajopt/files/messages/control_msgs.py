"""Messages of `control_msgs`: a trajectory for a controller, and its progress."""

from dataclasses import dataclass, field
from typing import ClassVar

from trajopt.files.messages.builtin_interfaces import Duration
from trajopt.files.messages.std_msgs import Header
from trajopt.files.messages.trajectory_msgs import (
    JointTrajectory,
    JointTrajectoryPoint,
    MultiDOFJointTrajectory,
)


@dataclass(slots=True)
class JointTolerance:
    """Largest deviation of a joint from its trajectory."""

    name: str = ""
    position: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0


@dataclass(slots=True)
class JointComponentTolerance:
    """Largest deviation of a joint of several degrees of freedom from its trajectory."""

    joint_name: str = ""
    component: int = 0
    position: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0


@dataclass(slots=True)
class FollowJointTrajectoryGoal:
    """A trajectory to be followed."""

    trajectory: JointTrajectory = field(default_factory=JointTrajectory)
    multi_dof_trajectory: MultiDOFJointTrajectory = field(default_factory=MultiDOFJointTrajectory)
    path_tolerance: list[JointTolerance] = field(default_factory=list[JointTolerance])
    component_path_tolerance: list[JointComponentTolerance] = field(
        default_factory=list[JointComponentTolerance]
    )
    goal_tolerance: list[JointTolerance] = field(default_factory=list[JointTolerance])
    component_goal_tolerance: list[JointComponentTolerance] = field(
        default_factory=list[JointComponentTolerance]
    )
    goal_time_tolerance: Duration = field(default_factory=Duration)


@dataclass(slots=True)
class FollowJointTrajectoryResult:
    """How following a trajectory ended."""

    SUCCESSFUL: ClassVar[int] = 0
    INVALID_GOAL: ClassVar[int] = -1
    INVALID_JOINTS: ClassVar[int] = -2
    OLD_HEADER_TIMESTAMP: ClassVar[int] = -3
    PATH_TOLERANCE_VIOLATED: ClassVar[int] = -4
    GOAL_TOLERANCE_VIOLATED: ClassVar[int] = -5

    error_code: int = 0
    error_string: str = ""


@dataclass(slots=True)
class FollowJointTrajectoryFeedback:
    """Actual and desired positions of the joints during execution."""

    header: Header = field(default_factory=Header)
    joint_names: list[str] = field(default_factory=list[str])
    desired: JointTrajectoryPoint = field(default_factory=JointTrajectoryPoint)
    actual: JointTrajectoryPoint = field(default_factory=JointTrajectoryPoint)
    error: JointTrajectoryPoint = field(default_factory=JointTrajectoryPoint)
