"""Messages of `actionlib_msgs` (ROS 1): identity and status of action goals."""

from dataclasses import dataclass, field
from typing import ClassVar

from trajopt.files.messages.builtin_interfaces import Time
from trajopt.files.messages.primitives import UInt8
from trajopt.files.messages.std_msgs import Header


@dataclass(slots=True)
class GoalID:
    """Identity of an action goal; if id and stamp are empty, all goals."""

    stamp: Time = field(default_factory=Time)
    id: str = ""


@dataclass(slots=True)
class GoalStatus:
    """How a goal is going."""

    PENDING: ClassVar[int] = 0
    ACTIVE: ClassVar[int] = 1
    PREEMPTED: ClassVar[int] = 2
    SUCCEEDED: ClassVar[int] = 3
    ABORTED: ClassVar[int] = 4
    REJECTED: ClassVar[int] = 5
    PREEMPTING: ClassVar[int] = 6
    RECALLING: ClassVar[int] = 7
    RECALLED: ClassVar[int] = 8
    LOST: ClassVar[int] = 9

    goal_id: GoalID = field(default_factory=GoalID)
    status: UInt8 = 0
    text: str = ""


@dataclass(slots=True)
class GoalStatusArray:
    """Status of the goals of an action."""

    header: Header = field(default_factory=Header)
    status_list: list[GoalStatus] = field(default_factory=list[GoalStatus])
