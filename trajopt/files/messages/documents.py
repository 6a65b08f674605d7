"""Convert messages, ours or ROS' own, to documents for the readers of MoveIt's files."""

from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from trajopt.values.documents.document import Node
from trajopt.values.errors import ProblemError, shown


def document_of(message: object, name: str) -> Node:
    """Return a message as a document.

    Args:
        message: A message of trajopt, ROS 1 or ROS 2.
        name: Name used in error messages instead of a file name, such as "set_path_constraints".

    Raises:
        ProblemError: If it is not a message.
    """
    return Node(_plain(message, name), name)


def _plain(value: Any, name: str) -> object:
    match value:
        case None | bool() | int() | float() | str() | bytes():
            return value
        case Mapping():
            return {str(key): _plain(inner, name) for key, inner in value.items()}  # pyright: ignore[reportUnknownVariableType, reportUnknownArgumentType]
        case np.ndarray() | np.generic():
            return _plain(value.tolist(), name)
        case _:
            members = field_names(value)
    if members or is_dataclass(value):
        return {key: _plain(getattr(value, key), name) for key in members}
    if isinstance(value, Iterable):
        return [_plain(inner, name) for inner in value]  # pyright: ignore[reportUnknownVariableType]
    raise ProblemError(f"{name}: {shown(value)} is not a message")


def field_names(message: Any) -> tuple[str, ...]:
    """Return the field names of a message; empty if it is not a message."""
    if is_dataclass(message):
        return tuple(each.name for each in fields(message))
    if hasattr(message, "get_fields_and_field_types"):  # ROS 2
        return tuple(message.get_fields_and_field_types())
    slots: Iterable[str] = getattr(message, "__slots__", ()) if hasattr(message, "_type") else ()  # ROS 1
    return tuple(slots)


def is_message(value: object, *names: str) -> bool:
    """Return whether an object has the fields of a message."""
    return set(names) <= set(field_names(value))
