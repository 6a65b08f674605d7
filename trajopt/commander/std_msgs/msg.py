"""Stands for `std_msgs.msg`: headers and colours."""

from dataclasses import dataclass, field

from trajopt.commander.rospy import Time


@dataclass(slots=True)
class Header:
    """When something was so, and in which frame."""

    seq: int = 0
    stamp: Time = field(default_factory=Time)
    frame_id: str = ""


@dataclass(slots=True)
class ColorRGBA:
    """Red, green, blue and opacity, in [0, 1]."""

    r: float = 0.0
    g: float = 0.0
    b: float = 0.0
    a: float = 0.0
