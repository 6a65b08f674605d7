"""Values as JSON and arrays: what a bundle's documents are made of.

A value of a kind (`trajopt/bundle/kinds.py`) is `{"kind": name, field: ...}` with the arguments of its
constructor, which checks them again when it is read; one of a few named values `{"kind": name, "is": name}`;
a mapping `{"map": {...}}`, or `{"pairs": [[key, value], ...]}` where its keys are no texts; a set
`{"set": [...]}`; a number that is not finite `{"number": "inf"}`; an array `{"array": [...], "type": ...}`,
or `{"array": name}` with a member of its own; the name of a file `{"file": name}`. A list is a sequence.
"""

from collections.abc import Mapping
from dataclasses import MISSING, Field, fields
from math import isfinite
from pathlib import Path
from typing import Any, cast

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from trajopt.bundle.kinds import is_enum, name_of
from trajopt.bundle.kinematics import kinematics_document
from trajopt.errors import ModelError, shown

SMALL = 64
"""Numbers of an array that is written into the document itself: people read those."""
TYPES = ("float64", "int64", "int32", "bool")
"""Types of numbers in arrays."""


class Writer:
    """Turns values into documents, and collects the arrays and files that they name.

    Attributes:
        arrays: Arrays by the name of their member.
        files: Files by the name of their member.
    """

    def __init__(self) -> None:
        """Begin without any."""
        self.arrays: dict[str, NDArray[np.generic]] = {}
        self.files: dict[str, Path] = {}
        self._by_path: dict[Path, str] = {}

    def document(self, value: object, place: str) -> object:
        """Return a value as a document.

        Args:
            value: The value.
            place: What it is called in messages.

        Raises:
            ModelError: If it holds something that is no data: code of the caller's.
        """
        match value:
            case None | bool() | str():
                return value
            case int() | np.integer():
                return int(value)
            case float() | np.floating():
                return float(value) if isfinite(value) else {"number": str(float(value))}
            case np.ndarray():
                return self._array(cast("NDArray[np.generic]", value))
            case list() | tuple():
                items = cast("list[object] | tuple[object, ...]", value)
                return [self.document(item, f"{place}[{i}]") for i, item in enumerate(items)]
            case set() | frozenset():
                members = [self.document(item, place) for item in cast("frozenset[object]", value)]
                return {"set": sorted(members, key=repr)}
            case Path():
                return {"file": self._file(value)}
            case pin.Model():
                return {"kinematics": self._tree(kinematics_document(value))}
            case Mapping():
                return self._mapping(cast("Mapping[object, object]", value), place)
            case _:
                return self._value(value, place)

    def _value(self, value: object, place: str) -> object:
        name = name_of(type(value))
        if name is None:
            what = f"{type(value).__module__}.{type(value).__qualname__}"
            raise ModelError(f"{place} is no data that a bundle can hold, but code: {shown(what)}")
        if is_enum(type(value)):
            return {"kind": name, "is": cast("Any", value).name}
        stated = {item.name: getattr(value, item.name) for item in fields(cast("Any", value)) if item.init}
        changed = {key: each for key, each in stated.items() if not _is_default(value, key, each)}
        return {"kind": name, **{k: self.document(each, f"{place}.{k}") for k, each in changed.items()}}

    def _mapping(self, value: Mapping[object, object], place: str) -> object:
        if all(isinstance(key, str) for key in value):
            return {"map": {str(k): self.document(each, f"{place}.{k}") for k, each in value.items()}}
        return {"pairs": [[self.document(k, place), self.document(v, place)] for k, v in value.items()]}

    def _array(self, value: NDArray[np.generic]) -> object:
        kind = str(value.dtype)
        if kind not in TYPES:
            value, kind = np.asarray(value, np.int64), "int64"
        if value.size <= SMALL and np.isfinite(cast("Any", value)).all() and value.size:
            return {"array": value.tolist(), "type": kind}
        name = f"arrays/{len(self.arrays)}.npy"
        self.arrays[name] = value
        return {"array": name}

    def _file(self, path: Path) -> str:
        if path not in self._by_path:
            if path.suffix.lower() == ".urdf" or not path.is_file():
                return path.name
            name = f"meshes/{len(self.files)}{path.suffix.lower()}"
            self._by_path[path], self.files[name] = name, path
        return self._by_path[path]

    def _tree(self, item: object) -> object:
        """Write the arrays of a plain document."""
        if isinstance(item, dict):
            return {key: self._tree(each) for key, each in cast("dict[str, object]", item).items()}
        if isinstance(item, list):
            return [self._tree(each) for each in cast("list[object]", item)]
        return self.document(item, "kinematics")


def _is_default(value: object, name: str, stated: object) -> bool:
    """Say whether a field has the value that it would have anyway."""
    item: Field[Any] = next(each for each in fields(cast("Any", value)) if each.name == name)
    if item.default is MISSING:
        return False
    if stated is item.default:
        return True
    plain = isinstance(stated, str | int | float)
    return plain and type(stated) is type(item.default) and stated == item.default
