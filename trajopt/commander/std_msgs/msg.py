"""Stands for `std_msgs.msg`: headers, colours and plain values."""

from dataclasses import dataclass, field

from trajopt.commander.clock import Time


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


@dataclass(slots=True)
class String:
    """A text."""

    data: str = ""


@dataclass(slots=True)
class Bool:
    """A truth."""

    data: bool = False


@dataclass(slots=True)
class Int8:
    """A whole number."""

    data: int = 0


@dataclass(slots=True)
class UInt8:
    """A whole number."""

    data: int = 0


@dataclass(slots=True)
class Int16:
    """A whole number."""

    data: int = 0


@dataclass(slots=True)
class UInt16:
    """A whole number."""

    data: int = 0


@dataclass(slots=True)
class Int32:
    """A whole number."""

    data: int = 0


@dataclass(slots=True)
class UInt32:
    """A whole number."""

    data: int = 0


@dataclass(slots=True)
class Int64:
    """A whole number."""

    data: int = 0


@dataclass(slots=True)
class UInt64:
    """A whole number."""

    data: int = 0


@dataclass(slots=True)
class Float32:
    """A number."""

    data: float = 0.0


@dataclass(slots=True)
class Float64:
    """A number."""

    data: float = 0.0


@dataclass(slots=True)
class Empty:
    """Nothing but that it was sent."""


@dataclass(slots=True)
class Float64MultiArray:
    """Numbers in a row; how they are laid out is not said."""

    layout: object = None
    data: list[float] = field(default_factory=list[float])
