"""Read-only float arrays, immutable values, and argument checks.

A check raises a ProblemError for a value of a wrong kind, and a ShapeError for a wrong number or shape.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from enum import Enum
from math import isfinite
from pathlib import Path
from typing import Any, Self, TypeAlias, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trajopt.values.errors import ModelError, ProblemError, ShapeError, SizeError, kind_words, shown

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]
Bools: TypeAlias = NDArray[np.bool_]

K = TypeVar("K")
V = TypeVar("V")
F = TypeVar("F")


NUMBERS = "iufO"
"""Array kinds that hold numbers; numpy would also convert text, truth values and dates."""


def readonly(array: Floats) -> Floats:
    """Return the array with writing forbidden (the same memory, flag cleared)."""
    array.flags.writeable = False
    return array


def is_array_like(value: object) -> bool:
    """Return whether a value is a list, a tuple, an array or a tensor."""
    return isinstance(value, list | tuple) or hasattr(value, "__array__")


def numbers(name: str, value: ArrayLike, required: str = "must be numbers") -> Floats:
    """Copy numbers into an array of their own shape."""
    try:
        given = np.asarray(value)
        if given.dtype.kind not in NUMBERS or (given.dtype == object and any(map(_no_number, given.flat))):
            raise TypeError("no numbers")
        return np.array(given, dtype=np.float64)
    except (TypeError, ValueError, OverflowError, RuntimeError) as error:
        raise ShapeError(name, f"{required}, is {shown(value)}{_particulars(value, error)}") from error


def floats(
    name: str,
    value: ArrayLike,
    shape: Sequence[int | None],
    *,
    infinite: bool = False,
) -> Floats:
    """Copy `value` into a read-only float array of a shape and check it.

    Args:
        shape: Required shape; None matches any length.
        infinite: Whether infinities are allowed (NaN never is).
    """
    array = numbers(name, value, "must be numbers" if tuple(shape) else "must be a number")
    expected = tuple(shape)
    if array.ndim != len(expected) or (
        array.shape != expected
        and any(want not in (None, have) for want, have in zip(expected, array.shape, strict=True))
    ):
        wanted = ", ".join("any" if n is None else str(n) for n in expected) + "," * (len(expected) == 1)
        if not expected:
            raise ShapeError(name, f"must be one number, has shape {array.shape}")
        raise ShapeError(name, f"needs shape ({wanted}), has {array.shape}")
    if not np.isfinite(array).all() and (not infinite or np.isnan(array).any()):
        raise ShapeError(name, f"holds a number that is not finite: {shown(array.tolist())}")
    return readonly(array)


def _particulars(value: object, error: Exception) -> str:
    """Return the type of an array, or the reason why an object, such as a tensor, does not become one."""
    if isinstance(value, np.ndarray):
        return f" of {cast('Floats', value).dtype}"
    return f": {error}" if hasattr(value, "__array__") else ""


def indices(name: str, value: object, width: int, count: int) -> Ints:
    """Copy rows of whole numbers into a fresh array of indices, shape (any, width), and check it."""
    try:
        given = np.asarray(value)
        truths = given is not value and _holds_truth_values(value)
    except (TypeError, ValueError, OverflowError, RecursionError) as error:
        raise ShapeError(name, f"must be rows of {width} whole numbers, is {shown(value)}") from error
    if given.dtype.kind not in "iu" or truths:
        raise ShapeError(name, f"must be rows of {width} whole numbers, is {shown(value)}")
    if given.ndim != 2 or given.shape[1] != width:
        raise ShapeError(name, f"needs shape (any, {width}), has {given.shape}")
    outside = (given < 0) | (given >= count)
    if outside.any():
        raise ShapeError(name, f"has {given[outside][0]}; indices run from 0 to {count - 1} here")
    return given.astype(np.int64)


def _holds_truth_values(rows: object) -> bool:
    entries: NDArray[Any] = np.asarray(rows, dtype=np.object_)
    return any(type(entry) in (bool, np.bool_) for entry in entries.flat)


def floats_of_any_shape(name: str, value: ArrayLike) -> Floats:
    try:
        given = np.asarray(value)
    except (TypeError, ValueError, OverflowError, RecursionError) as error:
        raise ShapeError(name, f"must be a number or an array of them, is {shown(value)}") from error
    if (given.dtype.kind not in "fiu" and given.size > 0) or np.isnan(given).any():
        raise ShapeError(name, f"must be a number or an array of them, is {shown(value)}")
    return given.astype(np.float64, copy=False)


def _no_number(value: object) -> bool:
    return value is None or isinstance(value, str | bytes | bool | np.bool_)


def number(name: str, value: float, *, infinite: bool = False) -> float:
    """Return `value` as a finite float."""
    if type(value) is float and isfinite(value):
        return value
    return float(floats(name, value, (), infinite=infinite))


def at_least(options: object, least: float, *names: str) -> None:
    """Check that fields of options are not below a bound."""
    for name in names:
        value = number(name, getattr(options, name), infinite=True)
        if value < least:
            raise ProblemError(f"{type(options).__name__}: {name} must be at least {least:g}, is {value:g}")


def above_zero(options: object, *names: str) -> None:
    """Check that fields of options are positive."""
    for name in names:
        value = number(name, getattr(options, name), infinite=True)
        if value <= 0.0:
            raise ProblemError(f"{type(options).__name__}: {name} must be positive, is {value:g}")


class Printed:
    """A dataclass that prints on one line; long fields are shortened, large arrays are shown by shape."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "__repr__" not in cls.__dict__:
            cls.__repr__ = cls.__repr__

    def __repr__(self) -> str:
        shown_fields = (item for item in fields(cast("Any", self)) if item.repr)
        parts = (f"{item.name}={shown(getattr(self, item.name))}" for item in shown_fields)
        return f"{type(self).__name__}({', '.join(parts)})"


class Value(Printed):
    """An immutable dataclass whose copies and pickles are immutable too.

    Copies and pickles contain the fields only.
    """

    def __getstate__(self) -> dict[str, object]:
        return {item.name: _kept(getattr(self, item.name)) for item in fields(cast("Any", self))}

    def __copy__(self) -> Self:
        other = object.__new__(type(self))
        for item in fields(cast("Any", self)):
            object.__setattr__(other, item.name, getattr(self, item.name))
        return other


class _ReadOnly:
    """A read-only array in a pickle; numpy does not preserve the flag."""

    def __init__(self, array: NDArray[Any]) -> None:
        self._array = array

    def __reduce__(self) -> tuple[Any, tuple[NDArray[Any]]]:
        return _closed, (self._array,)


def _closed(array: NDArray[Any]) -> NDArray[Any]:
    array.flags.writeable = False
    return array


def _kept(item: object) -> object:
    if isinstance(item, np.ndarray):
        array = cast("NDArray[Any]", item)
        return array if array.flags.writeable else _ReadOnly(array)
    if type(item) is tuple:
        several = cast("tuple[object, ...]", item)
        kept = tuple(map(_kept, several))
        return kept if any(a is not b for a, b in zip(kept, several, strict=True)) else several
    if type(item) is dict:
        named = cast("dict[object, object]", item)
        by_name = {name: _kept(each) for name, each in named.items()}
        return by_name if any(each is not named[name] for name, each in by_name.items()) else named
    return item


def mapping(name: str, value: Mapping[K, V]) -> Mapping[K, V]:
    """Return a mapping."""
    if not isinstance(value, Mapping):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ProblemError(f"{name} must be a mapping by name, is {shown(value)}")
    return value


def sequence(name: str, value: Iterable[V]) -> Sequence[V]:
    """Return the items of a collection."""
    if isinstance(value, str | bytes) or not isinstance(value, Iterable):  # pyright: ignore
        raise ProblemError(f"{name} must be a list or another collection, is {shown(value)}")
    return tuple(value)


def one_of(name: str, value: object, kind: type[V]) -> V:
    """Return a value of a class."""
    if not isinstance(value, kind) or (isinstance(value, type) and not issubclass(kind, type)):
        raise ProblemError(f"{name} must be {kind_words(kind)}, is {shown(value)}")
    return value


def unless_none(name: str, value: object, kind: type[V]) -> V | None:
    """Return a value of a class, or None."""
    return None if value is None else one_of(name, value, kind)


def function(name: str, value: F) -> F:
    """Return a callable, or None."""
    if value is not None and not callable(value):
        raise ProblemError(f"{name} must be a function, is {shown(value)}")
    return value


def several(name: str, value: Iterable[V], kind: type[V]) -> tuple[V, ...]:
    """Return the items of a collection that are all of a class."""
    if isinstance(value, str | bytes) or not isinstance(value, Iterable):  # pyright: ignore
        words = "a list of names" if kind is str else f"{kind_words(kind)} or several"
        raise ProblemError(f"{name} must be {words}, is {shown(value)}")
    return tuple(one_of(f"each of {name}", item, kind) for item in value)


def path(name: str, value: Path | str) -> Path:
    """Return the path of a file."""
    if not isinstance(value, Path | str):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ProblemError(f"{name} must be the path of a file, is {shown(value)}")
    return Path(value)


def name_of(what: str, value: str) -> str:
    """Return a name without lone surrogates, so that it can be written to files."""
    name = one_of(what, value, str)
    if any("\ud800" <= letter <= "\udfff" for letter in name):
        raise ModelError(
            f"{what} {shown(name)} has a character that UTF-8 cannot encode: name it differently"
        )
    return name


def direction_of(name: str, value: ArrayLike) -> Floats:
    """Return a vector scaled to length one, shape (3,)."""
    vector = floats(name, value, (3,))
    length = float(np.linalg.norm(vector))
    if length < 1e-9:
        raise ShapeError(name, "has no length, so it is not a direction")
    return readonly(vector / length)


def positive(name: str, value: float, *, infinite: bool = False) -> float:
    """Return a number that must be positive."""
    checked = number(name, value, infinite=infinite)
    if checked <= 0.0:
        raise ProblemError(f"{name} must be positive, is {checked:g}")
    return checked


def not_negative(name: str, value: float, *, infinite: bool = False) -> float:
    """Return a number that must not be negative."""
    checked = number(name, value, infinite=infinite)
    if checked < 0.0:
        raise ProblemError(f"{name} must not be negative, is {checked:g}")
    return checked


def runs_of(mask: Bools) -> Ints:
    """Return begin and end (exclusive) of each unbroken row of True, shape (k, 2)."""
    edges = np.diff(np.concatenate(([False], mask, [False])).astype(np.int8))
    return np.flatnonzero(edges).reshape(-1, 2)


class Loss(Enum):
    """Loss function of a residual r with weight w in a cost."""

    SQUARED = "w r^2"
    ABSOLUTE = "w |r|"
    HINGE = "w max(0, r)"


@dataclass(frozen=True, eq=False)
class Rows(Value):
    """Linearised residual rows, r(x + dx) = value + sum_k jacobian[:, k] . dx[knots[:, k]].

    Attributes:
        value: Residuals, shape (m,).
        jacobian: Derivatives by the knots of the stencil, shape (m, k, n).
        component: Component of the residual, or pair, of each row, shape (m,).
        place: Location of each row along the motion, in knots, shape (m,).
    """

    value: Floats
    jacobian: Floats
    knots: Ints
    component: Ints
    place: Floats


LARGEST_SIZE = 50.0
"""Larger sizes [m] are refused as likely millimetres."""


def length(name: str, value: float) -> float:
    checked = number(name, value)
    if checked <= 0.0:
        raise SizeError(name, f"must be positive, is {checked:g} m")
    if checked > LARGEST_SIZE:
        raise SizeError(name, f"is {checked:g} m; lengths are in metres: was {checked / 1000:g} m meant?")
    return checked
