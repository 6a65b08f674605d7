"""Values: what is immutable, and is pickled and copied as what it states, not as what was derived of it."""

from dataclasses import fields
from typing import Any, Self, cast

import numpy as np
from numpy.typing import NDArray


class Value:
    """An immutable dataclass whose copies and pickles are as immutable as itself.

    They hold its fields, nothing that was computed of them, and arrays that were read-only stay so.
    """

    def __getstate__(self) -> dict[str, object]:
        """Return the fields by name."""
        return {item.name: _kept(getattr(self, item.name)) for item in fields(cast("Any", self))}

    def __copy__(self) -> Self:
        """Return another value of the same fields."""
        other = object.__new__(type(self))
        for item in fields(cast("Any", self)):
            object.__setattr__(other, item.name, getattr(self, item.name))
        return other


class _ReadOnly:
    """Stands for a read-only array in a pickle: numpy itself forgets that it was."""

    def __init__(self, array: NDArray[Any]) -> None:
        self._array = array

    def __reduce__(self) -> tuple[Any, tuple[NDArray[Any]]]:
        return _closed, (self._array,)


def _closed(array: NDArray[Any]) -> NDArray[Any]:
    array.flags.writeable = False
    return array


def _kept(item: object) -> object:
    """Return what to pickle in the place of a field."""
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
