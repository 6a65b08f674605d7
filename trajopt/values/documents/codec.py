"""The codec of values: documents for JSON, and arrays in them.

Format: docs/bundles.md#file-format; a member of an enumeration is `{"kind": name, "is": name}`. Constructors
check their arguments again. Containers, such as `trajopt.files.bundle`, add documents of their own.
"""

from collections.abc import Callable, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import MISSING, Field, fields
from enum import Enum
from functools import cache
from importlib import import_module
from math import isfinite
from typing import Any, TypeGuard, cast, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from trajopt.values.documents.document import Node
from trajopt.values.errors import ModelError, TrajoptError, shown
from trajopt.values.errors.arguments import check_arguments

TYPES = ("float64", "int64", "int32", "bool")
Kinds = Mapping[str, type[Any]]
"""Classes by the names that files use: nothing else is ever made of a file."""
Form = Callable[[Node], object]
"""A mapping with a certain key -> the value that it states."""


def kinds_in(places: Mapping[str, str]) -> Kinds:
    """Return classes by name from their names, separated by blanks, by module."""
    return {name: getattr(import_module(at), name) for at, names in places.items() for name in names.split()}


class Writer:
    """Turns values into documents."""

    def __init__(self, kinds: Kinds) -> None:
        self._kinds = kinds

    def document(self, value: object, place: str) -> object:
        """Return a value as a document; raise a ModelError for an object that is not data."""
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
                return self.instance(value, place)

    def instance(self, value: object, place: str) -> object:
        """Return an instance of a class as a document."""
        name = self._name(value, place)
        stated = {item.name: getattr(value, item.name) for item in fields(cast("Any", value)) if item.init}
        changed = {key: each for key, each in stated.items() if not _is_default(value, key, each)}
        document = {k: self.document(each, f"{place}.{k}") for k, each in changed.items()}
        return {"kind": name, **{key_of(k): each for k, each in document.items()}}

    def array(self, value: NDArray[np.generic], place: str) -> object:
        """Return an array as a document."""
        value = of_known_type(value)
        if not np.isfinite(cast("Any", value)).all():
            raise ModelError(f"{place} has a number that is not finite")
        return {"array": value.tolist(), "type": str(value.dtype)}

    def _name(self, value: object, place: str) -> str:
        kind = type(value)
        if self._kinds.get(kind.__name__) is not kind:
            what = f"{kind.__module__}.{kind.__qualname__}"
            raise ModelError(f"{place} cannot be written: {shown(what)} is code, not data")
        return kind.__name__

    def _mapping(self, value: Mapping[object, object], place: str) -> object:
        if all(isinstance(key, str) for key in value):
            return {"map": {str(k): self.document(each, f"{place}.{k}") for k, each in value.items()}}
        pairs = [[self.document(k, place), self.document(v, place)] for k, v in value.items()]
        # The order may be a set's, which differs between processes: sorted, equal values give equal texts.
        return {"pairs": sorted(pairs, key=repr)}


class Reader:
    """Makes values of documents: only of known classes, each checked again."""

    def __init__(
        self,
        kinds: Kinds,
        check_fields: Callable[[type[Any], Mapping[str, Any]], None],
        check: Callable[[object], None],
        forms: Mapping[str, Form] | None = None,
    ) -> None:
        """Select the classes to read.

        Args:
            check_fields: Raises a typed error for arguments whose check in a constructor would take long.
            check: Raises a typed error for a value that native code would follow out of bounds.
        """
        self._kinds, self._check_fields, self._check = kinds, check_fields, check
        self._forms: Mapping[str, Form] = {
            "kind": self._kind,
            "map": self._map,
            "pairs": self._pairs,
            "set": self._set,
            "number": self._number,
            "array": self.array,
            **(forms or {}),
        }

    def value(self, node: Node) -> Any:
        """Return the value that a document states."""
        value = node.value
        if value is None or isinstance(value, bool | str | int | float):
            return value
        if isinstance(value, list):
            return tuple(self.value(item) for item in node.elements())
        if not is_mapping(value):
            raise node.error("is not a value")
        for key, read in self._forms.items():
            if key in value:
                return read(node)
        raise node.error(f"is not a value: it has none of {', '.join(self._forms)}")

    def _kind(self, node: Node) -> Any:
        name = node["kind"].text()
        kind = self._kinds.get(name)
        if kind is None:
            raise node["kind"].error(f"{shown(name)} is not among the {len(self._kinds)} known kinds")
        if issubclass(kind, Enum):
            return self._named(kind, node.only(("kind", "is")))
        names = [item.name for item in fields(kind) if item.init]
        node.only(("kind", *map(key_of, names)))
        stated = {name: key for name in names if (key := key_of(name)) in cast("Any", node.value)}
        given = {name: self.value(node[key]) for name, key in stated.items()}
        missing = [item.name for item in fields(kind) if _needed(item) and item.name not in given]
        if missing:
            raise node.error(f"lacks {', '.join(missing)}")
        try:
            check_arguments(kind, given)
            _check_members(kind, given)
            self._check_fields(kind, given)
            made = kind(**given)
            self._check(made)
        except TrajoptError as error:
            raise node.error(str(error)) from error
        except (TypeError, ValueError, KeyError, IndexError, AttributeError, OverflowError) as error:
            raise node.error(f"does not make a {name}: {error}") from error
        return made

    def _named(self, kind: type[Enum], node: Node) -> Enum:
        name = node["is"].text()
        if name not in kind.__members__:
            raise node["is"].error(f"must be one of {', '.join(kind.__members__)}, is {shown(name)}")
        return kind[name]

    def _map(self, node: Node) -> dict[str, Any]:
        inside = node.only(("map",))["map"]
        if not is_mapping(inside.value):
            raise inside.error("must be a mapping")
        return {key: self.value(inside[key]) for key in inside.value}

    def _pairs(self, node: Node) -> dict[Any, Any]:
        found: dict[Any, Any] = {}
        for item in node.only(("pairs",))["pairs"].elements():
            pair = item.elements()
            if len(pair) != 2:
                raise item.error("must be a key and a value")
            try:
                found[self.value(pair[0])] = self.value(pair[1])
            except TypeError as error:
                raise pair[0].error("cannot be a key") from error
        return found

    def _set(self, node: Node) -> frozenset[Any]:
        try:
            return frozenset(self.value(item) for item in node.only(("set",))["set"].elements())
        except TypeError as error:
            raise node.error("cannot be a set") from error

    def _number(self, node: Node) -> float:
        text = node.only(("number",))["number"].text()
        if text not in ("inf", "-inf", "nan"):
            raise node.error("must be inf, -inf or nan")
        return float(text)

    def array(self, node: Node) -> NDArray[np.generic]:
        """Return an array, read-only."""
        node.only(("array", "type"))
        kind = node["type"].text()
        if kind not in TYPES:
            raise node["type"].error(f"must be one of {', '.join(TYPES)}")
        try:
            array = np.array(node["array"].value, dtype=kind)
        except (TypeError, ValueError, OverflowError) as error:
            raise node.error(f"is not an array: {error}") from error
        array.flags.writeable = False
        return array


def key_of(field: str) -> str:
    return "kind_" if field == "kind" else field


def is_mapping(value: object) -> TypeGuard[dict[str, object]]:
    """Return whether a value of a document is a mapping."""
    return isinstance(value, dict)


def of_known_type(value: NDArray[np.generic]) -> NDArray[np.generic]:
    """Return an array of a type that files have; integers of other types become 64 bits wide."""
    return value if str(value.dtype) in TYPES else np.asarray(value, np.int64)


def _is_default(value: object, name: str, stated: object) -> bool:
    item: Field[Any] = next(each for each in fields(cast("Any", value)) if each.name == name)
    if item.default is MISSING:
        return False
    if stated is item.default:
        return True
    plain = isinstance(stated, str | int | float)
    return plain and type(stated) is type(item.default) and stated == item.default


def _needed(item: Field[Any]) -> bool:
    return item.init and item.default is MISSING and item.default_factory is MISSING


def _check_members(kind: type[Any], given: Mapping[str, Any]) -> None:
    hints = _hints(kind)
    for name, value in given.items():
        hint = hints.get(name)
        if get_origin(hint) is not Mapping or not isinstance(value, Mapping):
            continue
        inner = get_args(hint)[1]
        wanted = get_origin(inner) or inner
        if not isinstance(wanted, type):
            continue
        kinds = (int, float) if wanted is float else (wanted,)
        for each in cast("Mapping[object, object]", value).values():
            if not isinstance(each, kinds) or (wanted is float and isinstance(each, bool)):
                raise ModelError(f"each of {name} must be a {wanted.__name__}, is {shown(each)}")


@cache
def _hints(kind: type[Any]) -> Mapping[str, Any]:
    try:
        return get_type_hints(kind)
    except NameError:
        return {}
