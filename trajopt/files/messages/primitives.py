"""ROS primitive types without a Python equivalent: sized integers and short floats.

In a field, `int` is an int32, `float` a float64, `str` a string and `bool` a bool.
"""

from dataclasses import dataclass
from typing import Annotated, TypeAlias


@dataclass(frozen=True)
class Primitive:
    """Name and integer range of a ROS primitive type.

    Attributes:
        name: Its name in ROS.
        lowest: Smallest integer; None for types that are not integers.
        highest: Largest integer; None for types that are not integers.
    """

    name: str
    lowest: int | None = None
    highest: int | None = None


def _signed(bits: int) -> Primitive:
    return Primitive(f"int{bits}", -(2 ** (bits - 1)), 2 ** (bits - 1) - 1)


def _unsigned(bits: int) -> Primitive:
    return Primitive(f"uint{bits}", 0, 2**bits - 1)


Int8: TypeAlias = Annotated[int, _signed(8)]
Int16: TypeAlias = Annotated[int, _signed(16)]
Int64: TypeAlias = Annotated[int, _signed(64)]
UInt8: TypeAlias = Annotated[int, _unsigned(8)]
UInt16: TypeAlias = Annotated[int, _unsigned(16)]
UInt32: TypeAlias = Annotated[int, _unsigned(32)]
UInt64: TypeAlias = Annotated[int, _unsigned(64)]
Bytes: TypeAlias = Annotated[bytes, _unsigned(8)]
"""A large list of uint8, which rosbridge writes in base64."""
Float32: TypeAlias = Annotated[float, Primitive("float32")]

PLAIN = {
    bool: Primitive("bool"),
    int: _signed(32),
    float: Primitive("float64"),
    str: Primitive("string"),
}
"""ROS types of Python's own types."""
