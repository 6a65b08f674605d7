"""Messages of ROS as data classes, made when first used, and as plain data."""

import sys
import time
from base64 import b64decode, b64encode
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, make_dataclass
from enum import Enum
from functools import cache
from math import isfinite, isnan
from types import ModuleType
from typing import Any, ClassVar, Self, TypeAlias, cast

import numpy as np

from trajopt.files.messages.definitions import INITIAL, INTEGERS, MessageDefinition, MessageField, definitions
from trajopt.values.documents.document import Node
from trajopt.values.errors import MessageNotFound, ProblemError, listed, shown

NANOSECONDS = 10**9
KINDS = ("msg", "srv", "action")
"""Folder of a message in ROS 2, between its package and its name."""
ROS1_TIMES = {"time": "builtin_interfaces/Time", "duration": "builtin_interfaces/Duration"}


class Message:
    """A message of ROS."""

    __slots__ = ()
    definition: ClassVar[MessageDefinition]


@dataclass(slots=True, order=True)
class Stamp(Message):
    """Whole seconds and nanoseconds; comparable within one class."""

    secs: float = 0
    nsecs: int = 0

    def __post_init__(self) -> None:
        total = round(self.secs * NANOSECONDS) + self.nsecs
        self.secs, self.nsecs = divmod(total, NANOSECONDS)

    def to_sec(self) -> float:
        return self.secs + self.nsecs / NANOSECONDS

    def to_nsec(self) -> int:
        return int(self.secs) * NANOSECONDS + self.nsecs

    @classmethod
    def from_sec(cls, seconds: float) -> Self:
        return cls(seconds)


class Duration(Stamp):
    """A duration, `builtin_interfaces/Duration` (in ROS 1 `duration`)."""

    __slots__ = ()
    definition = definitions()["builtin_interfaces/Duration"]

    def __add__(self, other: "Duration") -> "Duration":
        return Duration(0, self.to_nsec() + other.to_nsec())

    def __sub__(self, other: "Duration") -> "Duration":
        return Duration(0, self.to_nsec() - other.to_nsec())

    def __mul__(self, factor: float) -> "Duration":
        return Duration(0, round(self.to_nsec() * factor))

    __rmul__ = __mul__

    def __truediv__(self, by: "float | Duration") -> "Duration | float":
        if isinstance(by, Duration):
            return self.to_nsec() / by.to_nsec()
        return Duration(0, round(self.to_nsec() / by))

    def __neg__(self) -> "Duration":
        return Duration(0, -self.to_nsec())

    def __abs__(self) -> "Duration":
        return Duration(0, abs(self.to_nsec()))


class Time(Stamp):
    """A time since the epoch, `builtin_interfaces/Time` (in ROS 1 `time`)."""

    __slots__ = ()
    definition = definitions()["builtin_interfaces/Time"]

    @classmethod
    def now(cls) -> "Time":
        return cls(*divmod(time.time_ns(), NANOSECONDS))

    def __add__(self, span: Duration) -> "Time":
        return Time(0, self.to_nsec() + span.to_nsec())

    def __sub__(self, other: "Time | Duration") -> "Duration | Time":
        kind = Duration if isinstance(other, Time) else Time
        return kind(0, self.to_nsec() - other.to_nsec())


class CollisionMatrixMethods(Message):
    """Methods of MoveIt's `AllowedCollisionMatrix`."""

    __slots__ = ()
    entry_names: list[str]
    entry_values: list[Any]
    default_entry_names: list[str]
    default_entry_values: list[bool]

    def set_default(self, obj: str, allow: bool) -> None:
        if obj in self.default_entry_names:
            self.default_entry_values[self.default_entry_names.index(obj)] = allow
        else:
            self.default_entry_names.append(obj)
            self.default_entry_values.append(allow)

    def set_allowed(self, obj: str, other: str | None = None, allow: bool = True) -> None:
        """Allow or forbid contact of two links or objects, or of one with everything (`other` None)."""
        if other is None:
            self.set_default(obj, allow)
            return
        for name in (obj, other):
            if name not in self.entry_names:
                self.entry_names.append(name)
                for row in self.entry_values:
                    row.enabled.append(False)
                self.entry_values.append(
                    message_named("moveit_msgs/AllowedCollisionEntry")([False] * len(self.entry_names))
                )
        first, second = self.entry_names.index(obj), self.entry_names.index(other)
        self.entry_values[first].enabled[second] = allow
        self.entry_values[second].enabled[first] = allow


_TIMES: Mapping[str, type[Message]] = {kind.definition.name: kind for kind in (Time, Duration)}
_BASES: Mapping[str, type[Message]] = {"moveit_msgs/AllowedCollisionMatrix": CollisionMatrixMethods}


def message_named(name: str) -> type[Any]:
    """Return the class of a message."""
    wanted = plain_name(ROS1_TIMES.get(name, name))
    if wanted not in definitions():
        raise MessageNotFound("message", name, definitions())
    return _class_of(wanted)


def classes_of(package: str) -> Mapping[str, type[Message]]:
    """Return the classes of a package's messages, such as "std_msgs", by name."""
    names = (each.partition("/") for each in definitions())
    return {name: _class_of(f"{package}/{name}") for owner, _, name in names if owner == package}


def class_in(package: str = "") -> Callable[[str], Any]:
    """Return the `__getattr__` of a module with the messages of a package, or of all packages if empty."""

    def find(name: str) -> Any:
        for full in definitions():
            owner, _, plain = full.partition("/")
            if plain == name and package in ("", owner):
                return _class_of(full)
        raise AttributeError(f"there is no message {name} of ROS in {package or 'the table'}")

    return find


PACKAGES = (
    "geometry_msgs",
    "moveit_msgs",
    "sensor_msgs",
    "shape_msgs",
    "std_msgs",
    "trajectory_msgs",
    "visualization_msgs",
)


def import_package(parent: str, name: str) -> ModuleType:
    """Return a module with the messages of a package, importable by its name: `PARENT.geometry_msgs.msg`."""
    package = ModuleType(f"{parent}.{name}", f"Stand-in for the ROS package {name}.")
    module = ModuleType(f"{package.__name__}.msg", f"Messages of {name}.")
    vars(module).update(classes_of(name), __getattr__=class_in(name))
    vars(package).update(msg=module, __path__=[])
    sys.modules.update({each.__name__: each for each in (package, module)})
    return package


def name_of(kind: type[Any], *, between: str = "") -> str:
    """Return the full name of a message, in ROS 2 with the folder ("msg", "srv", "action") between."""
    package, _, name = kind.definition.name.partition("/")
    return "/".join(part for part in (package, between, name) if part)


def plain_name(name: str) -> str:
    """Return a name in ROS 1 form, without "msg", "srv" or "action" in the middle."""
    first, *rest = name.split("/")
    return "/".join((first, *(part for part in rest if part not in KINDS)))


@cache
def _class_of(name: str) -> type[Message]:
    if name in _TIMES:
        return _TIMES[name]
    definition = definitions()[name]
    namespace = {**definition.constants, "definition": definition, "__doc__": f"`{name}`."}
    made = make_dataclass(
        name.partition("/")[2],
        [(each.name, object, _initial(each)) for each in definition.fields],
        bases=(_BASES.get(name, Message),),
        namespace=namespace,
        slots=True,
    )
    made.__module__ = "trajopt.files.messages"  # pickle finds the class by its name there
    return made


def _initial(member: MessageField) -> Any:
    if member.default is not None:
        return field(default=member.default)
    if member.kind in INITIAL:
        return field(default=INITIAL[member.kind])
    return field(default_factory=list[Any] if member.kind.endswith("[]") else _class_of(member.kind))


_HEADER, _QUATERNION = message_named("std_msgs/Header"), message_named("geometry_msgs/Quaternion")


class Generation(Enum):
    """The generations of ROS, which differ in times, headers and the initial value of a quaternion.

    Attributes:
        seconds: Names of the two parts of a time.
        initial_w: The w of a quaternion of which only x, y or z is given.
    """

    ROS1 = (("secs", "nsecs"), 0.0)
    ROS2 = (("sec", "nanosec"), 1.0)

    def __init__(self, seconds: tuple[str, str], initial_w: float) -> None:
        self.seconds = seconds
        self.initial_w = initial_w


Decoder: TypeAlias = Callable[[object, Generation], object]
"""Plain data, and the generation that it is of -> the value of a field."""


class _Mismatch(Exception):
    """Plain data that does not fit a message: the place, from the innermost outwards, and the reason."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason
        self.place: list[str] = []

    def within(self, place: str) -> "_Mismatch":
        self.place.append(place)
        return self

    def sentence(self) -> str:
        where = "".join(reversed(self.place)).removeprefix(".")
        return f"{where}: {self.reason}" if where else self.reason


def encode(message: object, generation: Generation = Generation.ROS2) -> Any:
    """Return a message as plain data for JSON; non-finite numbers become null, as in rosbridge."""
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
            names = _written(type(message), generation)
            return {name: encode(getattr(message, name), generation) for name in names}


def decode(
    kind: type[Any], document: object, generation: Generation = Generation.ROS2, *, name: str = "message"
) -> Any:
    """Return the message of plain data.

    Missing fields, and null in fields that are not numbers, take ROS' defaults. A list in place of a message
    has its fields in order, as in MoveIt's files. Times are {sec, nanosec}, {secs, nsecs}, or seconds.

    Args:
        name: Name used in error messages instead of a file name.

    Raises:
        FileFormatError: If a field is unknown or its value is not of its type.
    """
    node = document if isinstance(document, Node) else Node(document, name)
    try:
        return _decoder(kind.definition.name)(node.value, generation)
    except _Mismatch as mismatch:
        inside = Node(None, node.path, node.place)
        raise inside.error(mismatch.sentence()) from None


def document_of(message: object, name: str) -> Node:
    """Return a message as a document, which the readers of MoveIt's files take."""
    return Node(_plain(message, name), name)


def field_names(message: Any) -> tuple[str, ...]:
    """Return the names of the fields of a message or its class; none if it is not a message."""
    if is_dataclass(message):
        return tuple(each.name for each in fields(message))
    if hasattr(message, "get_fields_and_field_types"):  # ROS 2
        return tuple(message.get_fields_and_field_types())
    slots: Iterable[str] = getattr(message, "__slots__", ()) if hasattr(message, "_type") else ()  # ROS 1
    return tuple(slots)


def is_message(value: object, *names: str) -> bool:
    """Return whether a value has these fields of a message."""
    return set(names) <= set(field_names(value))


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


@cache
def _written(kind: type[Message], generation: Generation) -> tuple[str, ...]:
    names = tuple(each.name for each in kind.definition.fields)
    return names[1:] if kind is _HEADER and generation is Generation.ROS2 else names  # without `seq`


@cache
def _decoder(kind: str) -> Decoder:
    if kind == "uint8[]":
        return _bytes
    if kind.endswith("[]"):
        return _list_of(_decoder(kind.removesuffix("[]")))
    if kind in INTEGERS:
        return _whole_number(*INTEGERS[kind])
    if kind in _PLAIN:
        return _PLAIN[kind]
    message = message_named(kind)
    return _stamp(message) if issubclass(message, Stamp) else _message(message)


def _bytes(value: object, _: Generation) -> bytes:
    try:
        if isinstance(value, str):
            return b64decode(value, validate=True)
        if value is not None and not isinstance(value, list):
            raise TypeError(f"is {shown(value)}")
        return bytes(cast("list[int]", value or []))
    except (TypeError, ValueError) as error:
        raise _Mismatch(f"must be base64, or a list of whole numbers from 0 to 255: {error}") from None


def _flag(value: object, _: Generation) -> bool:
    if value in (True, False):
        return bool(value)
    raise _Mismatch(f"must be true or false, is {_shown(value)}")


def _text(value: object, _: Generation) -> str:
    if isinstance(value, str):
        return value
    raise _Mismatch(f"must be text, is {_shown(value)}")


def _real_number(value: object, _: Generation) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise _Mismatch(f"must be a number, is {_shown(value)}")
    try:
        number = float(value)
    except OverflowError:
        raise _Mismatch(f"exceeds numbers of 64 bits: {_shown(value)}") from None
    if isnan(number):
        raise _Mismatch("must be a number, is not one (NaN)")
    return number


_PLAIN: Mapping[str, Decoder] = {
    "bool": _flag,
    "string": _text,
    "float32": _real_number,
    "float64": _real_number,
}


def _whole_number(lowest: int, highest: int) -> Decoder:
    def read(value: object, _: Generation) -> int:
        if not isinstance(value, int | float) or isinstance(value, bool):
            raise _Mismatch(f"must be a whole number, is {_shown(value)}")
        if value != value // 1 or not lowest <= value <= highest:
            raise _Mismatch(f"must be a whole number from {lowest} to {highest}, is {_shown(value)}")
        return int(value)

    return read


def _shown(value: object) -> str:
    return "null" if value is None else shown(value)


def _list_of(element: Decoder) -> Decoder:
    def read(value: object, generation: Generation) -> list[object]:
        if value is None:
            return []
        if not isinstance(value, list | tuple):
            raise _Mismatch(f"must be a list, is {_shown(value)}")
        found: list[object] = []
        for each in cast("list[object]", value):
            try:
                found.append(element(each, generation))
            except _Mismatch as mismatch:
                raise mismatch.within(f"[{len(found)}]") from None
        return found

    return read


_PARTS = tuple(zip(*(each.seconds for each in Generation), strict=True))


def _stamp(kind: type[Stamp]) -> Decoder:
    known = frozenset(part for each in Generation for part in each.seconds)

    def read(value: object, generation: Generation) -> Stamp:
        if value is None:
            return kind()
        if value == "now" and issubclass(kind, Time):  # rosbridge fills in the time
            return kind.now()
        if isinstance(value, int | float) and not isinstance(value, bool):
            return kind(_finite(value))
        members = _mapping(value, kind, known)
        whole, rest = (next((members[p] for p in pair if p in members), 0) for pair in _PARTS)
        return kind(_finite(whole), int(_finite(rest)))

    return read


def _finite(value: object) -> float:
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 2.0**63:
        return value
    raise _Mismatch(f"must count seconds and nanoseconds, is {_shown(value)}")


def _mapping(value: object, kind: type[Message], known: frozenset[str]) -> Mapping[str, object]:
    if not isinstance(value, Mapping):
        raise _Mismatch(f"must be a {name_of(kind)}, is {_shown(value)}")
    members = cast("Mapping[str, object]", value)
    unknown = next((key for key in members if key not in known), None)
    if unknown is not None:
        raise _Mismatch(f"{name_of(kind)} has no field {shown(unknown)}; it has {listed(sorted(known))}")
    return members


def _message(kind: type[Message]) -> Decoder:
    definition, make = kind.definition, cast("Callable[..., object]", kind)
    readers = {each.name: _decoder(each.kind) for each in definition.fields}
    known = frozenset(readers)
    # JSON has no NaN: null in a number is one that could not be written, and not a missing field.
    numbers = {each.name for each in definition.fields if each.kind in (*INTEGERS, "float32", "float64")}

    def read(value: object, generation: Generation) -> object:
        if value is None:
            return make()
        if isinstance(value, list | tuple):
            given = cast("list[object]", value)
            if len(given) > len(readers):
                raise _Mismatch(f"{definition.name} has {len(readers)} fields, not {len(given)}")
            value = dict(zip(readers, given, strict=False))
        made: dict[str, object] = {}
        for name, inner in _mapping(value, kind, known).items():
            if inner is None and name not in numbers:
                continue
            try:
                made[name] = readers[name](inner, generation)
            except _Mismatch as mismatch:
                raise mismatch.within(f".{name}") from None
        if kind is _QUATERNION and made:
            made.setdefault("w", generation.initial_w)
        return make(**made)

    return read
