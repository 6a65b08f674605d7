"""Messages of ROS as data classes, each made from its definition when it is first used."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, make_dataclass
from functools import cache
from typing import Any, ClassVar, Self

from trajopt.files.messages.definitions import INITIAL, MessageDefinition, MessageField, definitions
from trajopt.values.errors import MessageNotFound

NANOSECONDS = 10**9
KINDS = ("msg", "srv", "action")
"""Folder of a message in ROS 2, between its package and its name."""
ROS1_TIMES = {"time": "builtin_interfaces/Time", "duration": "builtin_interfaces/Duration"}
"""Names of times in ROS 1."""


class Message:
    """A message of ROS."""

    __slots__ = ()
    definition: ClassVar[MessageDefinition]


@dataclass(slots=True, order=True)
class Stamp(Message):
    """Whole seconds and nanoseconds; comparable within one class.

    Attributes:
        secs: Whole seconds; fractions, as in `Duration(0.5)`, are carried over to `nsecs`.
        nsecs: Nanoseconds, from 0 to 999,999,999.
    """

    secs: float = 0
    nsecs: int = 0

    def __post_init__(self) -> None:
        total = round(self.secs * NANOSECONDS) + self.nsecs
        self.secs, self.nsecs = divmod(total, NANOSECONDS)

    def to_sec(self) -> float:
        """Return the time in seconds [s]."""
        return self.secs + self.nsecs / NANOSECONDS

    def to_nsec(self) -> int:
        """Return the time in nanoseconds [ns]."""
        return int(self.secs) * NANOSECONDS + self.nsecs

    @classmethod
    def from_sec(cls, seconds: float) -> Self:
        """Return the duration of a number of seconds, or the time this long after the epoch."""
        return cls(seconds)


class Duration(Stamp):
    """A duration, `builtin_interfaces/Duration` (in ROS 1 `duration`)."""

    __slots__ = ()
    definition = definitions()["builtin_interfaces/Duration"]

    def __add__(self, other: "Duration") -> "Duration":
        return Duration(0, self.to_nsec() + other.to_nsec())

    def __sub__(self, other: "Duration") -> "Duration":
        return Duration(0, self.to_nsec() - other.to_nsec())


class Time(Stamp):
    """A time since the epoch, `builtin_interfaces/Time` (in ROS 1 `time`)."""

    __slots__ = ()
    definition = definitions()["builtin_interfaces/Time"]

    @classmethod
    def now(cls) -> "Time":
        """Return the present time."""
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
        """Allow or forbid contact of a link or object with everything."""
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
    """Return the class of a message.

    Args:
        name: Its name as ROS 1 or ROS 2 writes it, such as "std_msgs/String" or "std_msgs/msg/String".

    Raises:
        MessageNotFound: If it is not in the table.
    """
    wanted = plain_name(ROS1_TIMES.get(name, name))
    if wanted not in definitions():
        raise MessageNotFound("message", name, definitions())
    return _class_of(wanted)


def classes_of(package: str) -> Mapping[str, type[Message]]:
    """Return the classes of a package's messages by name, such as those of "std_msgs"."""
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


def name_of(kind: type[Any], *, between: str = "") -> str:
    """Return the full name of a message, such as `std_msgs/String`.

    Args:
        kind: The message's class.
        between: Folder in ROS 2: "msg", "srv" or "action"; empty as in ROS 1.
    """
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
