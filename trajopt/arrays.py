"""Read-only float arrays with checked shapes: what every value of trajopt is made of."""

from collections.abc import Sequence
from math import isfinite
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trajopt.errors import ShapeError
from trajopt.shown import shown

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]
Bools: TypeAlias = NDArray[np.bool_]


def readonly(array: Floats) -> Floats:
    """Return the array with writing forbidden (the same memory, flag cleared)."""
    array.flags.writeable = False
    return array


def floats(
    name: str,
    value: ArrayLike,
    shape: Sequence[int | None],
    *,
    infinite: bool = False,
) -> Floats:
    """Copy `value` into a read-only float array and check it.

    Args:
        name: Name of the argument, for the error.
        value: Anything that numpy can read.
        shape: Required shape; None stands for any length.
        infinite: Whether infinities are allowed (not-a-number never is).

    Returns:
        A fresh read-only array of that shape.

    Raises:
        ShapeError: If the shape differs or a number is not finite.
    """
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError, RecursionError) as error:
        raise ShapeError(name, f"not numbers: {shown(value)}") from error
    expected = tuple(shape)
    if array.ndim != len(expected) or (
        array.shape != expected
        and any(want not in (None, have) for want, have in zip(expected, array.shape, strict=True))
    ):
        wanted = "(" + ", ".join("any" if n is None else str(n) for n in expected) + ")"
        raise ShapeError(name, f"needs shape {wanted}, has {array.shape}")
    if not np.isfinite(array).all() and (not infinite or np.isnan(array).any()):
        raise ShapeError(name, f"holds a number that is not finite: {shown(array.tolist())}")
    return readonly(array)


def number(name: str, value: float, *, infinite: bool = False) -> float:
    """Return `value` as a finite float.

    Raises:
        ShapeError: If it is not a number, or not finite.
    """
    if type(value) is float and isfinite(value):
        return value
    return float(floats(name, value, (), infinite=infinite))
