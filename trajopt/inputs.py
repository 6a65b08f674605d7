"""Checks of what users pass in where types alone would not tell them what is wrong."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

from trajopt.errors import ProblemError
from trajopt.shown import shown

Key = TypeVar("Key")
Value = TypeVar("Value")


def mapping(name: str, value: Mapping[Key, Value]) -> Mapping[Key, Value]:
    """Return a mapping.

    Raises:
        ProblemError: If it is none.
    """
    if not isinstance(value, Mapping):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ProblemError(f"{name} is a mapping by name, is {shown(value)}")
    return value


def sequence(name: str, value: Iterable[Value]) -> Sequence[Value]:
    """Return the items of a collection.

    Raises:
        ProblemError: If it is none, or a single text.
    """
    if isinstance(value, str | bytes) or not isinstance(value, Iterable):  # pyright: ignore
        raise ProblemError(f"{name} is a collection, is {shown(value)}")
    return tuple(value)


def one_of(name: str, value: object, kind: type[Value]) -> Value:
    """Return a value of a class.

    Raises:
        ProblemError: If it is of another.
    """
    if not isinstance(value, kind):
        raise ProblemError(f"{name} is a {kind.__name__}, is {shown(value)}")
    return value


def path(name: str, value: Path | str) -> Path:
    """Return the path of a file.

    Raises:
        ProblemError: If it is none.
    """
    if not isinstance(value, Path | str):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ProblemError(f"{name} is the path of a file, is {shown(value)}")
    return Path(value)
