"""Messages of `sensor_msgs`: joint states."""

from dataclasses import dataclass, field

from trajopt.messages.geometry_msgs import Transform, Twist, Wrench
from trajopt.messages.std_msgs import Header


@dataclass(slots=True)
class JointState:
    """Positions [rad | m], velocities and efforts of joints by name."""

    header: Header = field(default_factory=Header)
    name: list[str] = field(default_factory=list[str])
    position: list[float] = field(default_factory=list[float])
    velocity: list[float] = field(default_factory=list[float])
    effort: list[float] = field(default_factory=list[float])


@dataclass(slots=True)
class MultiDOFJointState:
    """Where joints of several degrees of freedom have their links: a base that moves in the plane."""

    header: Header = field(default_factory=Header)
    joint_names: list[str] = field(default_factory=list[str])
    transforms: list[Transform] = field(default_factory=list[Transform])
    twist: list[Twist] = field(default_factory=list[Twist])
    wrench: list[Wrench] = field(default_factory=list[Wrench])
