"""Values of trajopt's own classes as plain data that JSON can hold, and back.

A value is a mapping with `class`, the name of its class, and its fields by name. Arrays are {"floats": [...]}
or {"ints": [...]}, sets {"set": [...]}, mappings {"map": [[key, value], ...]}, members of an enumeration
{"enum": "Kind", "name": "REACHED"}, and numbers without limit {"number": "inf"}; lists are tuples.
"""

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import fields, is_dataclass
from enum import Enum
from math import inf, isfinite
from typing import Any, cast

import numpy as np

from trajopt.errors import FileFormatError, TrajoptError, shown
from trajopt.io.document import Node

LIMITS = {"inf": inf, "-inf": -inf}
Kinds = Mapping[str, type[Any]]
"""Classes by name: only these are read."""


def plain(value: object) -> object:
    """Return a value as plain data; the module says how.

    Raises:
        TypeError: If it holds what is no value.
    """
    match value:
        case None | bool() | int() | str():
            return value
        case float():
            return value if isfinite(value) else {"number": f"{value:g}"}
        case Enum():
            return {"enum": type(value).__name__, "name": value.name}
        case np.ndarray():
            array = cast("np.ndarray[Any, Any]", value)
            return {"floats" if array.dtype.kind == "f" else "ints": array.tolist()}
        case Mapping():
            items = cast("Mapping[object, object]", value).items()
            return {"map": [[plain(key), plain(each)] for key, each in items]}
        case AbstractSet():
            return {"set": sorted((plain(each) for each in cast("AbstractSet[object]", value)), key=str)}
        case Sequence():
            return [plain(each) for each in cast("Sequence[object]", value)]
        case _ if is_dataclass(value) and not isinstance(value, type):
            parts = {item.name: plain(getattr(value, item.name)) for item in fields(value) if item.init}
            return {"class": type(value).__name__, **parts}
        case _:
            raise TypeError(f"a {type(value).__name__} is no value")


def restored(node: Node, kinds: Kinds) -> Any:
    """Return the value that plain data stands for.

    Args:
        node: The data.
        kinds: Classes that it may hold.

    Raises:
        FileFormatError: If it is no such data, or a class refuses its fields.
    """
    if isinstance(node.value, list):
        return tuple(restored(each, kinds) for each in node.elements())
    if not isinstance(node.value, dict):
        return node.value
    members = node.members()
    match sorted(members):
        case ["number"]:
            return _one_of(members["number"], LIMITS, "number")
        case ["floats"] | ["ints"]:
            return _array(node)
        case ["set"]:
            return frozenset(restored(each, kinds) for each in members["set"].elements())
        case ["map"]:
            pairs = [restored(pair, kinds) for pair in members["map"].elements()]
            if any(not isinstance(pair, tuple) or len(cast("tuple[Any]", pair)) != 2 for pair in pairs):
                raise members["map"].error("is a list of pairs [key, value]")
            return dict(pairs)
        case ["enum", "name"]:
            kind = _one_of(members["enum"], kinds, "enumeration")
            return _one_of(members["name"], dict(kind.__members__), f"member of {kind.__name__}")
        case _:
            return _made(node, members, kinds)


def _made(node: Node, members: Mapping[str, Node], kinds: Kinds) -> Any:
    """Return what a class makes of its fields."""
    kind: type[Any] = _one_of(node["class"], kinds, "class")
    if issubclass(kind, Enum):
        raise node["class"].error(f"{kind.__name__} is an enumeration: it has a name")
    taken = [item.name for item in fields(kind) if item.init]
    node.only(("class", *taken))
    given = {name: restored(each, kinds) for name, each in members.items() if name != "class"}
    try:
        return kind(**given)
    except FileFormatError:
        raise
    except (TrajoptError, TypeError, ValueError) as error:
        raise node.error(f"is no {kind.__name__}: {error}") from error


def _array(node: Node) -> np.ndarray[Any, Any]:
    name = next(iter(node.members()))
    try:
        array = np.array(node[name].value, dtype=np.float64 if name == "floats" else np.int64)
    except (TypeError, ValueError) as error:
        raise node[name].error(f"is no array of numbers: {error}") from error
    if not np.isfinite(array).all():
        raise node[name].error("has a number that is not finite")
    array.flags.writeable = False
    return array


def _one_of(node: Node, known: Mapping[str, Any], what: str) -> Any:
    name = node.text()
    if name not in known:
        raise node.error(f"no {what} {shown(name)} here; known: {', '.join(known)}")
    return known[name]
