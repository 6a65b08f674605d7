"""Messages of `trajectory_msgs`: joint trajectories."""

from dataclasses import dataclass, field

from trajopt.files.messages.builtin_interfaces import Duration
from trajopt.files.messages.geometry_msgs import Transform, Twist
from trajopt.files.messages.std_msgs import Header


@dataclass(slots=True)
class JointTrajectoryPoint:
    """Joint positions [rad | m], their derivatives, and the time."""

    positions: list[float] = field(default_factory=list[float])
    velocities: list[float] = field(default_factory=list[float])
    accelerations: list[float] = field(default_factory=list[float])
    effort: list[float] = field(default_factory=list[float])
    time_from_start: Duration = field(default_factory=Duration)


@dataclass(slots=True)
class JointTrajectory:
    """Points of joints over time."""

    header: Header = field(default_factory=Header)
    joint_names: list[str] = field(default_factory=list[str])
    points: list[JointTrajectoryPoint] = field(default_factory=list[JointTrajectoryPoint])


@dataclass(slots=True)
class MultiDOFJointTrajectoryPoint:
    """Transforms of joints of several degrees of freedom, their derivatives, and the time."""

    transforms: list[Transform] = field(default_factory=list[Transform])
    velocities: list[Twist] = field(default_factory=list[Twist])
    accelerations: list[Twist] = field(default_factory=list[Twist])
    time_from_start: Duration = field(default_factory=Duration)


@dataclass(slots=True)
class MultiDOFJointTrajectory:
    """Points of joints of several degrees of freedom, such as a planar base, over time."""

    header: Header = field(default_factory=Header)
    joint_names: list[str] = field(default_factory=list[str])
    points: list[MultiDOFJointTrajectoryPoint] = field(default_factory=list[MultiDOFJointTrajectoryPoint])
