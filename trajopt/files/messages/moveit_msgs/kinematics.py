"""Messages of `moveit_msgs` on link poses and on contacts of a state."""

from dataclasses import dataclass, field
from typing import ClassVar

from trajopt.files.messages.builtin_interfaces import Duration
from trajopt.files.messages.geometry_msgs import Point, PoseStamped, Vector3
from trajopt.files.messages.moveit_msgs.constraints import Constraints
from trajopt.files.messages.moveit_msgs.planning_scene import RobotState
from trajopt.files.messages.primitives import UInt32
from trajopt.files.messages.std_msgs import Header


@dataclass(slots=True)
class PositionIKRequest:
    """Target poses of links, and the seed state of the search.

    `attempts` is from early ROS 1 and ignored: the search chooses its number of restarts.
    """

    group_name: str = ""
    robot_state: RobotState = field(default_factory=RobotState)
    constraints: Constraints = field(default_factory=Constraints)
    avoid_collisions: bool = False
    ik_link_name: str = ""
    pose_stamped: PoseStamped = field(default_factory=PoseStamped)
    ik_link_names: list[str] = field(default_factory=list[str])
    pose_stamped_vector: list[PoseStamped] = field(default_factory=list[PoseStamped])
    timeout: Duration = field(default_factory=Duration)
    attempts: int = 0


@dataclass(slots=True)
class ContactInformation:
    """A contact of two bodies: position, normal and depth [m]."""

    ROBOT_LINK: ClassVar[int] = 0
    WORLD_OBJECT: ClassVar[int] = 1
    ROBOT_ATTACHED: ClassVar[int] = 2

    header: Header = field(default_factory=Header)
    position: Point = field(default_factory=Point)
    normal: Vector3 = field(default_factory=Vector3)
    depth: float = 0.0
    contact_body_1: str = ""
    body_type_1: UInt32 = 0
    contact_body_2: str = ""
    body_type_2: UInt32 = 0


@dataclass(slots=True)
class CostSource:
    """A box with a cost density; trajopt does not use it."""

    cost_density: float = 0.0
    aabb_min: Vector3 = field(default_factory=Vector3)
    aabb_max: Vector3 = field(default_factory=Vector3)


@dataclass(slots=True)
class ConstraintEvalResult:
    """Whether a constraint holds, and the distance of a state from it [rad | m]."""

    result: bool = False
    distance: float = 0.0
