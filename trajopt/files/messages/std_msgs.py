"""Messages of `std_msgs`: headers, colours and plain values."""

from dataclasses import dataclass, field

from trajopt.files.messages.builtin_interfaces import Time
from trajopt.files.messages.primitives import Float32 as Float32Number
from trajopt.files.messages.primitives import Int8 as Int8Number
from trajopt.files.messages.primitives import Int16 as Int16Number
from trajopt.files.messages.primitives import Int64 as Int64Number
from trajopt.files.messages.primitives import UInt8 as UInt8Number
from trajopt.files.messages.primitives import UInt16 as UInt16Number
from trajopt.files.messages.primitives import UInt32 as UInt32Number
from trajopt.files.messages.primitives import UInt64 as UInt64Number


@dataclass(slots=True)
class Header:
    """Time and frame of the data."""

    seq: UInt32Number = 0
    stamp: Time = field(default_factory=Time)
    frame_id: str = ""


@dataclass(slots=True)
class ColorRGBA:
    """Red, green, blue and opacity, in [0, 1]."""

    r: Float32Number = 0.0
    g: Float32Number = 0.0
    b: Float32Number = 0.0
    a: Float32Number = 0.0


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

    data: Int8Number = 0


@dataclass(slots=True)
class UInt8:
    """A whole number."""

    data: UInt8Number = 0


@dataclass(slots=True)
class Int16:
    """A whole number."""

    data: Int16Number = 0


@dataclass(slots=True)
class UInt16:
    """A whole number."""

    data: UInt16Number = 0


@dataclass(slots=True)
class Int32:
    """A whole number."""

    data: int = 0


@dataclass(slots=True)
class UInt32:
    """A whole number."""

    data: UInt32Number = 0


@dataclass(slots=True)
class Int64:
    """A whole number."""

    data: Int64Number = 0


@dataclass(slots=True)
class UInt64:
    """A whole number."""

    data: UInt64Number = 0


@dataclass(slots=True)
class Float32:
    """A number."""

    data: Float32Number = 0.0


@dataclass(slots=True)
class Float64:
    """A number."""

    data: float = 0.0


@dataclass(slots=True)
class Empty:
    """Nothing but that it was sent."""


@dataclass(slots=True)
class MultiArrayDimension:
    """One dimension of an array: name, length and stride."""

    label: str = ""
    size: UInt32Number = 0
    stride: UInt32Number = 0


@dataclass(slots=True)
class MultiArrayLayout:
    """Memory layout of an array; unspecified without dimensions."""

    dim: list[MultiArrayDimension] = field(default_factory=list[MultiArrayDimension])
    data_offset: UInt32Number = 0


@dataclass(slots=True)
class Float64MultiArray:
    """Numbers in a row."""

    layout: MultiArrayLayout = field(default_factory=MultiArrayLayout)
    data: list[float] = field(default_factory=list[float])


@dataclass(slots=True)
class Float32MultiArray:
    """Numbers in a row."""

    layout: MultiArrayLayout = field(default_factory=MultiArrayLayout)
    data: list[Float32Number] = field(default_factory=list[Float32Number])


@dataclass(slots=True)
class Int8MultiArray:
    """Whole numbers in a row."""

    layout: MultiArrayLayout = field(default_factory=MultiArrayLayout)
    data: list[Int8Number] = field(default_factory=list[Int8Number])
