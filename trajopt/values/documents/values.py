"""Values as JSON and arrays: what the documents of bundles and of recordings are made of.

A value of a kind is `{"kind": name, field: ...}` with the arguments of its constructor, without those that
have their default; the constructor checks them again when it is read
(`trajopt/values/documents/read_values.py`). A field
that is itself named `kind` is written `kind_`. One of a few named values is `{"kind": name, "is": name}`; a
mapping `{"map": {...}}`, or `{"pairs": [[key, value], ...]}` where its keys are no texts; a set
`{"set": [...]}`; a number that is not finite `{"number": "inf"}`; an array `{"array": [...], "type": ...}`. A
list is a sequence. What else there may be, whoever writes a file adds.
"""

from collections.abc import Mapping
from collections.abc import Set as AbstractSet
from dataclasses import MISSING, Field, fields
from enum import Enum
from importlib import import_module
from math import isfinite
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from trajopt.values.errors import ModelError, shown

TYPES = ("float64", "int64", "int32", "bool")
"""Types of numbers in arrays."""
Kinds = Mapping[str, type[Any]]
"""Classes by the names that files use: nothing else is ever made of what a file says."""


def kinds_in(places: Mapping[str, str]) -> Kinds:
    """Return kinds by name.

    A name stays what it is when the class is moved: then its new place is written beside it.

    Args:
        places: The names of classes, with a blank between them, by the module that they are in.
    """
    return {name: getattr(import_module(at), name) for at, names in places.items() for name in names.split()}


class Writer:
    """Turns values into documents."""

    def __init__(self, kinds: Kinds) -> None:
        """Begin without any.

        Args:
            kinds: What may be written.
        """
        self._kinds = kinds

    def document(self, value: object, place: str) -> object:
        """Return a value as a document.

        Args:
            value: The value.
            place: What it is called in messages.

        Raises:
            ModelError: If it holds something that is not data: code of the caller's.
        """
        match value:
            case Enum():
                return {"kind": self._name(value, place), "is": value.name}
            case None | bool() | str():
                return value
            case int() | np.integer():
                return int(value)
            case float() | np.floating():
                return float(value) if isfinite(value) else {"number": str(float(value))}
            case np.ndarray():
                return self.array(cast("NDArray[np.generic]", value), place)
            case list() | tuple():
                items = cast("list[object] | tuple[object, ...]", value)
                return [self.document(item, f"{place}[{i}]") for i, item in enumerate(items)]
            case AbstractSet():
                members = [self.document(item, place) for item in cast("frozenset[object]", value)]
                return {"set": sorted(members, key=repr)}
            case Mapping():
                return self._mapping(cast("Mapping[object, object]", value), place)
            case _:
                return self.other(value, place)

    def array(self, value: NDArray[np.generic], place: str) -> object:
        """Return an array as a document.

        Raises:
            ModelError: If it has a number that is not finite, which has no place in a document.
        """
        value = of_known_type(value)
        if not np.isfinite(cast("Any", value)).all():
            raise ModelError(f"{place} has a number that is not finite")
        return {"array": value.tolist(), "type": str(value.dtype)}

    def other(self, value: object, place: str) -> object:
        """Return a value of a kind as a document.

        Raises:
            ModelError: If it is of none.
        """
        name = self._name(value, place)
        stated = {item.name: getattr(value, item.name) for item in fields(cast("Any", value)) if item.init}
        changed = {key: each for key, each in stated.items() if not _is_default(value, key, each)}
        document = {k: self.document(each, f"{place}.{k}") for k, each in changed.items()}
        return {"kind": name, **{key_of(k): each for k, each in document.items()}}

    def _name(self, value: object, place: str) -> str:
        kind = type(value)
        if self._kinds.get(kind.__name__) is not kind:
            what = f"{kind.__module__}.{kind.__qualname__}"
            raise ModelError(f"{place} is not data that a file can hold, but code: {shown(what)}")
        return kind.__name__

    def _mapping(self, value: Mapping[object, object], place: str) -> object:
        if all(isinstance(key, str) for key in value):
            return {"map": {str(k): self.document(each, f"{place}.{k}") for k, each in value.items()}}
        pairs = [[self.document(k, place), self.document(v, place)] for k, v in value.items()]
        # Their order may be that of a set, which differs from process to process: the same value, one text.
        return {"pairs": sorted(pairs, key=repr)}


def key_of(field: str) -> str:
    """Return the key of a field in a document: its name, but for that which says what kind of value it is."""
    return "kind_" if field == "kind" else field


def of_known_type(value: NDArray[np.generic]) -> NDArray[np.generic]:
    """Return an array of a type that files have: whole numbers of other types become those of 64 bits."""
    return value if str(value.dtype) in TYPES else np.asarray(value, np.int64)


def _is_default(value: object, name: str, stated: object) -> bool:
    """Say whether a field has the value that it would have anyway."""
    item: Field[Any] = next(each for each in fields(cast("Any", value)) if each.name == name)
    if item.default is MISSING:
        return False
    if stated is item.default:
        return True
    plain = isinstance(stated, str | int | float)
    return plain and type(stated) is type(item.default) and stated == item.default
