"""Convert messages to documents and back, as in rosbridge: JSON data with fields by name."""

from base64 import b64decode, b64encode
from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, fields
from enum import Enum
from functools import cache
from math import isfinite, isnan
from typing import (
    Annotated,
    Any,
    ClassVar,
    Protocol,
    TypeAlias,
    TypeVar,
    cast,
    get_args,
    get_origin,
    get_type_hints,
)

from trajopt.files.messages.builtin_interfaces import Stamp, Time
from trajopt.files.messages.geometry_msgs import Quaternion
from trajopt.files.messages.names import name_of
from trajopt.files.messages.primitives import PLAIN, Primitive
from trajopt.files.messages.std_msgs import Header
from trajopt.values.documents.document import Node
from trajopt.values.errors import listed, shown

M = TypeVar("M")


class DataClass(Protocol):
    """The interface of every message."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]


Decoder: TypeAlias = Callable[[object, "Generation"], object]
"""Converts a value in a document to a field of a message."""


class Generation(Enum):
    """The message formats of ROS 1 and ROS 2: they differ in times, headers and the default quaternion.

    Attributes:
        seconds: Field names of the two parts of a time.
        still: Default w of a quaternion.
    """

    ROS1 = (("secs", "nsecs"), 0.0)
    ROS2 = (("sec", "nanosec"), 1.0)

    def __init__(self, seconds: tuple[str, str], still: float) -> None:
        """Store the differences."""
        self.seconds = seconds
        self.still = still


class _Wrong(Exception):
    """A document does not fit a message: the place, from the innermost outwards, and the reason."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason
        self.place: list[str] = []

    def within(self, place: str) -> "_Wrong":
        self.place.append(place)
        return self

    def sentence(self) -> str:
        where = "".join(reversed(self.place)).removeprefix(".")
        return f"{where}: {self.reason}" if where else self.reason


def encode(message: object, generation: Generation = Generation.ROS2) -> object:
    """Return a message as a document; as in rosbridge, non-finite numbers become null.

    Args:
        message: A message, or a plain value.
        generation: The format: ROS 1 has `secs`, `nsecs` and the `seq` of a header.
    """
    match message:
        case float():
            return message if isfinite(message) else None
        case None | bool() | int() | str():
            return message
        case bytes():
            return b64encode(message).decode()
        case list() | tuple():
            return [encode(each, generation) for each in cast("list[object]", message)]
        case Stamp():
            whole, rest = generation.seconds
            return {whole: int(message.secs), rest: message.nsecs}
        case _:
            members = _names(type(message), generation)
            return {name: encode(getattr(message, name), generation) for name in members}


def decode(
    kind: type[M], document: object, generation: Generation = Generation.ROS2, *, name: str = "message"
) -> M:
    """Return the message of a document.

    Missing fields, and null in fields that are not numbers, take ROS' defaults. A list in place of a message
    contains its fields in order, as in MoveIt's files. Times are {sec, nanosec}, {secs, nsecs}, or seconds.

    Args:
        kind: The message's class.
        document: The document, or a node of one.
        generation: Selects the w of a quaternion with only x, y or z given: 0 in ROS 1, 1 in ROS 2.
        name: Name used in error messages instead of a file name.

    Raises:
        FileFormatError: If a field is unknown or has a value of the wrong type.
    """
    node = document if isinstance(document, Node) else Node(document, name)
    try:
        return cast("M", _decoder(kind)(node.value, generation))
    except _Wrong as wrong:
        inside = Node(None, node.path, node.place)
        raise inside.error(wrong.sentence()) from None


@cache
def _names(kind: type, generation: Generation) -> tuple[str, ...]:
    names = tuple(each.name for each in fields(kind))
    return names[1:] if kind is Header and generation is Generation.ROS2 else names


@cache
def _decoder(kind: Any) -> Decoder:
    """Return the decoder of a type: a message, a list or a plain value."""
    if get_origin(kind) is list:
        return _list_of(_decoder(get_args(kind)[0]))
    if get_origin(kind) is Annotated:
        plain, what = get_args(kind)
        if plain is bytes:
            return _bytes
        return _plain(plain, what)
    if kind in PLAIN:
        return _plain(kind, PLAIN[kind])
    message = cast("type[DataClass]", kind)
    return _stamp(message) if issubclass(message, Stamp) else _message(message)


def _bytes(value: object, _: Generation) -> object:
    """Read bytes: base64 as in rosbridge, or a list of numbers from 0 to 255."""
    try:
        if isinstance(value, str):
            return b64decode(value, validate=True)
        if value is not None and not isinstance(value, list):
            raise TypeError(f"is {shown(value)}")
        return bytes(cast("list[int]", value or []))
    except (TypeError, ValueError) as error:
        raise _Wrong(f"must be base64, or a list of whole numbers from 0 to 255: {error}") from None


def _plain(kind: type, what: Primitive) -> Decoder:
    def read(value: object, _: Generation) -> object:
        if kind is bool:
            if value in (True, False):
                return bool(value)
        elif kind is str:
            if isinstance(value, str):
                return value
        elif isinstance(value, int | float) and not isinstance(value, bool):
            return _number(_as_float(value) if kind is float else value, what)
        raise _Wrong(f"must be {_ARTICLES[kind]}, is {_said(value)}")

    return read


_ARTICLES = {bool: "true or false", str: "text", int: "a whole number", float: "a number"}


def _said(value: object) -> str:
    return "null" if value is None else shown(value)


def _as_float(value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        raise _Wrong(f"is beyond all numbers of 64 bits: {_said(value)}") from None


def _number(value: float, what: Primitive) -> float:
    if isinstance(value, float) and isnan(value):
        raise _Wrong("must be a number, is not one (NaN)")
    if what.lowest is None or what.highest is None:
        return value
    if value != value // 1 or not what.lowest <= value <= what.highest:
        raise _Wrong(f"must be a whole number from {what.lowest} to {what.highest}, is {_said(value)}")
    return int(value)


def _list_of(element: Decoder) -> Decoder:
    def read(value: object, generation: Generation) -> object:
        if value is None:
            return []
        if not isinstance(value, list | tuple):
            raise _Wrong(f"must be a list, is {_said(value)}")
        found: list[object] = []
        for each in cast("list[object]", value):
            try:
                found.append(element(each, generation))
            except _Wrong as wrong:
                raise wrong.within(f"[{len(found)}]") from None
        return found

    return read


def _stamp(kind: type[Stamp]) -> Decoder:
    def read(value: object, generation: Generation) -> object:
        if value is None:
            return kind()
        if value == "now" and issubclass(kind, Time):  # a keyword of rosbridge
            return kind.now()
        if isinstance(value, int | float) and not isinstance(value, bool):
            return kind(_finite(value))
        members = _mapping(value, kind)
        known = {part for each in Generation for part in each.seconds}
        _refuse_unknown(members, known, kind)
        whole, rest = (next((members[p] for p in pair if p in members), 0) for pair in _PARTS)
        return kind(_finite(whole), int(_finite(rest)))

    return read


_PARTS = tuple(zip(*(each.seconds for each in Generation), strict=True))
"""Field names of seconds and of nanoseconds."""


def _finite(value: object) -> float:
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 2.0**63:
        return value
    raise _Wrong(f"must count seconds and nanoseconds, has {_said(value)}")


def _mapping(value: object, kind: type) -> Mapping[str, object]:
    if not isinstance(value, Mapping):
        raise _Wrong(f"must be a {name_of(kind)}, is {_said(value)}")
    return cast("Mapping[str, object]", value)


def _refuse_unknown(members: Mapping[str, object], known: object, kind: type) -> None:
    assert isinstance(known, set | frozenset)
    names = cast("set[str]", known)
    strange = [key for key in members if key not in names]
    if strange:
        raise _Wrong(f"{name_of(kind)} has no field {shown(strange[0])}; it has {listed(sorted(names))}")


def _message(kind: type[DataClass]) -> Decoder:
    hints = get_type_hints(kind, include_extras=True)
    own: tuple[Field[Any], ...] = fields(kind)
    readers = {each.name: _decoder(hints[each.name]) for each in own}
    assert all(each.default is not MISSING or each.default_factory is not MISSING for each in own)
    known, numeric = frozenset(readers), _numeric(hints)
    make = cast("Callable[..., object]", kind)

    def read(value: object, generation: Generation) -> object:
        if value is None:
            return kind()
        if isinstance(value, list | tuple):
            given = cast("list[object]", value)
            if len(given) > len(own):
                raise _Wrong(f"{name_of(kind)} has {len(own)} fields, not {len(given)}")
            value = dict(zip(readers, given, strict=False))
        members = _mapping(value, kind)
        if not members.keys() <= known:
            _refuse_unknown(members, known, kind)
        made: dict[str, object] = {}
        for name, inner in members.items():
            if inner is None and name not in numeric:
                continue
            try:
                made[name] = readers[name](inner, generation)
            except _Wrong as wrong:
                raise wrong.within(f".{name}") from None
        if kind is Quaternion and made:
            made.setdefault("w", generation.still)
        return make(**made)

    return read


def _numeric(hints: Mapping[str, Any]) -> frozenset[str]:
    """Return the numeric fields; in these, null is a non-finite number, not a missing value."""
    plain = (int, float)
    return frozenset(name for name, hint in hints.items() if hint in plain or get_origin(hint) is Annotated)
