"""Names of messages in ROS: `moveit_msgs/PlanningScene`, or `moveit_msgs/msg/PlanningScene` in ROS 2."""

from dataclasses import is_dataclass
from functools import cache
from importlib import import_module
from inspect import getmembers, isclass
from types import ModuleType

from trajopt.values.errors import MessageNotFound

PACKAGES = (
    *("actionlib_msgs", "builtin_interfaces", "control_msgs", "geometry_msgs", "moveit_msgs"),
    *("object_recognition_msgs", "octomap_msgs", "sensor_msgs", "shape_msgs", "std_msgs"),
    *("trajectory_msgs", "visualization_msgs"),
)
"""ROS packages whose messages trajopt defines."""
KINDS = ("msg", "srv", "action")
"""The middle part of a ROS 2 message name, between package and name."""
OLD_NAMES = {"time": "builtin_interfaces/Time", "duration": "builtin_interfaces/Duration"}
"""ROS 1 names of the time and duration types."""


def package_of(kind: type) -> str:
    """Return the ROS package of a message."""
    return kind.__module__.split(".")[3]


def name_of(kind: type, *, between: str = "") -> str:
    """Return the name of a message, such as `std_msgs/String`.

    Args:
        kind: The message's class.
        between: Middle part of a ROS 2 name: "msg", "srv" or "action"; empty as in ROS 1.
    """
    return "/".join(part for part in (package_of(kind), between, kind.__name__) if part)


def plain_name(name: str) -> str:
    """Return a name in ROS 1 form, without "msg", "srv" or "action" in the middle."""
    first, *rest = name.split("/")
    return "/".join((first, *(part for part in rest if part not in KINDS)))


@cache
def messages() -> dict[str, type]:
    """Return all messages by name, in ROS 1 form."""
    found: dict[str, type] = {}
    for package in PACKAGES:
        module = import_module(f"trajopt.files.messages.{package}")
        found.update((name_of(kind), kind) for kind in _defined(module, package))
    return found


def _defined(module: ModuleType, package: str) -> list[type]:
    kinds = [kind for _, kind in getmembers(module, isclass) if is_dataclass(kind)]
    here = f"trajopt.files.messages.{package}"
    return [kind for kind in kinds if f"{kind.__module__}.".startswith(f"{here}.")]


def message_named(name: str) -> type:
    """Return the class of a message.

    Args:
        name: Its name, in the form of ROS 1 or ROS 2.

    Raises:
        MessageNotFound: If no message has this name.
    """
    wanted = plain_name(OLD_NAMES.get(name, name))
    if wanted not in messages():
        raise MessageNotFound("message", name, messages())
    return messages()[wanted]
