"""Read values from documents; the inverse of `trajopt/values/documents/values.py`."""

from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, fields
from enum import Enum
from functools import cache
from typing import Any, TypeGuard, cast, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from trajopt.values.documents.document import Node
from trajopt.values.documents.values import TYPES, Kinds, key_of
from trajopt.values.errors import ModelError, TrajoptError, shown
from trajopt.values.errors.arguments import check_arguments

Form = Callable[[Node], object]
"""Makes a value of a mapping that has a certain key."""


class Reader:
    """Makes values of documents, and nothing else: only of known kinds, checked again."""

    def __init__(
        self,
        kinds: Kinds,
        check_fields: Callable[[type[Any], Mapping[str, Any]], None],
        check: Callable[[object], None],
        forms: Mapping[str, Form] | None = None,
    ) -> None:
        """Note what there may be.

        Args:
            kinds: What may be read.
            check_fields: Refuses, by a typed error, what the constructor of a kind would take long for.
            check: Refuses, by a typed error, a value that code would follow out of bounds.
            forms: Readers of mappings by key, in addition to those of `trajopt/values/documents/values.py`.
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
        """Return the value that a document states.

        Raises:
            FileFormatError: If it states none.
        """
        value = node.value
        if value is None or isinstance(value, bool | str | int | float):
            return value
        if isinstance(value, list):
            return tuple(self.value(item) for item in node.elements())
        if not is_mapping(value):
            raise node.error("is no value")
        for key, read in self._forms.items():
            if key in value:
                return read(node)
        raise node.error(f"is no value: it has none of {', '.join(self._forms)}")

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
        """Return an array, read-only.

        Raises:
            FileFormatError: If it is none.
        """
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


def is_mapping(value: object) -> TypeGuard[dict[str, object]]:
    """Say whether a value of a document is a mapping."""
    return isinstance(value, dict)


def _needed(item: Field[Any]) -> bool:
    return item.init and item.default is MISSING and item.default_factory is MISSING


def _check_members(kind: type[Any], given: Mapping[str, Any]) -> None:
    """Refuse mappings whose members are not of the kinds that their annotations name.

    Raises:
        ModelError: If one is not.
    """
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
    """Return the annotations of a kind; none where only type checkers import what they name."""
    try:
        return get_type_hints(kind)
    except NameError:
        return {}
