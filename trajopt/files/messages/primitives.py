"""Plain values of ROS that Python has no type of its own for: whole numbers by size, and short numbers.

A field that says `int` is an int32, `float` a float64, `str` a string and `bool` a bool.
"""

from dataclasses import dataclass
from typing import Annotated, TypeAlias


@dataclass(frozen=True)
class Primitive:
    """What ROS calls a plain value, and the whole numbers that it holds.

    Attributes:
        name: Its name in ROS.
        lowest: The lowest whole number; None where it holds any number.
        highest: The highest whole number; None where it holds any number.
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
"""A list of uint8 that is large: rosbridge writes it in base64."""
Float32: TypeAlias = Annotated[float, Primitive("float32")]

PLAIN = {
    bool: Primitive("bool"),
    int: _signed(32),
    float: Primitive("float64"),
    str: Primitive("string"),
}
"""What a field of Python's own types is in ROS."""
