"""Stands for `trajectory_msgs.msg`: joint trajectories."""

from dataclasses import dataclass, field

from trajopt.commander.rospy import Duration
from trajopt.commander.std_msgs.msg import Header


@dataclass(slots=True)
class JointTrajectoryPoint:
    """Where the joints are [rad | m], how fast, and when."""

    positions: list[float] = field(default_factory=list[float])
    velocities: list[float] = field(default_factory=list[float])
    accelerations: list[float] = field(default_factory=list[float])
    effort: list[float] = field(default_factory=list[float])
    time_from_start: Duration = field(default_factory=Duration)


@dataclass(slots=True)
class JointTrajectory:
    """Points over time, of joints by name."""

    header: Header = field(default_factory=Header)
    joint_names: list[str] = field(default_factory=list[str])
    points: list[JointTrajectoryPoint] = field(default_factory=list[JointTrajectoryPoint])


@dataclass(slots=True)
class MultiDOFJointTrajectory:
    """Points of joints of several degrees of freedom; always empty here."""

    header: Header = field(default_factory=Header)
    joint_names: list[str] = field(default_factory=list[str])
    points: list[object] = field(default_factory=list[object])
