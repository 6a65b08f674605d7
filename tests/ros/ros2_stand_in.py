"""Modules of ROS 2 that are not installable here: names and behaviour that a node of a page needs of them."""

from collections.abc import Callable, Mapping
from dataclasses import is_dataclass
from types import ModuleType
from typing import Any, ClassVar

from trajopt.ros.commander.geometry_msgs import msg as geometry
from trajopt.ros.commander.sensor_msgs import msg as sensor

from trajopt.files.messages import FollowJointTrajectoryGoal, JointTrajectoryPoint
from trajopt.files.messages.message import Stamp


class Parameter:
    """A parameter, as `rclpy.parameter.Parameter`."""

    def __init__(self, value: object) -> None:
        self.value = value


class Log(list[str]):
    """The lines of a node."""

    def info(self, line: str) -> None:
        self.append(f"info: {line}")

    def warning(self, line: str) -> None:
        self.append(f"warning: {line}")

    def error(self, line: str) -> None:
        self.append(f"error: {line}")


class Node:
    """A node, as `rclpy.node.Node`; a test calls what it subscribes.

    Attributes:
        given: Values of parameters, as after `--ros-args -p`.
        heard: The functions that take messages, by topic.
        log: What it logs.
    """

    given: ClassVar[Mapping[str, object]] = {}

    def __init__(self, name: str) -> None:
        self.name, self.log = name, Log()
        self.heard: dict[str, Callable[[object], None]] = {}
        self._parameters: dict[str, Parameter] = {}

    def declare_parameter(self, name: str, value: object) -> None:
        self._parameters[name] = Parameter(self.given.get(name, value))

    def get_parameter(self, name: str) -> Parameter:
        return self._parameters[name]

    def create_subscription(
        self, kind: type, topic: str, callback: Callable[[object], None], depth: int
    ) -> None:
        assert isinstance(kind, type) and depth > 0

        def hear(message: object) -> None:
            assert isinstance(message, kind)
            callback(message)

        self.heard[topic] = hear

    def get_logger(self) -> Log:
        return self.log


class GoalHandle:
    """What a server answers to a goal."""

    def __init__(self, *, accepted: bool) -> None:
        self.accepted = accepted


class Future:
    """A future that is done."""

    def __init__(self, value: object) -> None:
        self._value = value

    def result(self) -> object:
        return self._value

    def add_done_callback(self, callback: Callable[["Future"], None]) -> None:
        callback(self)


class ActionClient:
    """A client of an action, as `rclpy.action.ActionClient`.

    Attributes:
        goals: The goals that were sent.
        there: Whether the server is there.
        accepts: Whether it accepts goals.
    """

    def __init__(self, node: Node, kind: Any, name: str) -> None:
        assert isinstance(node, Node) and name.startswith("/")
        self.goals: list[Any] = []
        self.there = self.accepts = True
        self._kind = kind

    def wait_for_server(self, timeout_sec: float) -> bool:
        assert timeout_sec > 0.0
        return self.there

    def send_goal_async(self, goal: object) -> Future:
        assert isinstance(goal, self._kind.Goal)
        self.goals.append(goal)
        return Future(GoalHandle(accepted=self.accepts))


class FollowJointTrajectory:
    """`control_msgs.action.FollowJointTrajectory`."""

    Goal = FollowJointTrajectoryGoal


def set_message_fields(message: Any, values: Mapping[str, Any]) -> None:
    """Set fields of a message from plain data, as `rosidl_runtime_py.set_message` does: of the same kinds."""
    for name, value in values.items():
        now = getattr(message, name)  # raises if there is no such field
        if isinstance(now, Stamp):
            assert set(value) == {"sec", "nanosec"}
            setattr(message, name, type(now)(value["sec"], value["nanosec"]))
        elif is_dataclass(now):
            set_message_fields(now, value)
        else:
            assert isinstance(value, type(now)), f"{name} is {value}"
            setattr(message, name, [_point(each) for each in value] if name == "points" else value)


def _point(values: Mapping[str, Any]) -> JointTrajectoryPoint:
    point = JointTrajectoryPoint()
    set_message_fields(point, values)
    return point


def modules() -> dict[str, ModuleType]:
    """Return the modules by name."""
    contents: Mapping[str, Mapping[str, object]] = {
        "rclpy": {},
        "rclpy.node": {"Node": Node},
        "rclpy.action": {"ActionClient": ActionClient},
        "control_msgs": {},
        "control_msgs.action": {"FollowJointTrajectory": FollowJointTrajectory},
        "geometry_msgs": {},
        "geometry_msgs.msg": vars(geometry),
        "sensor_msgs": {},
        "sensor_msgs.msg": vars(sensor),
        "rosidl_runtime_py": {},
        "rosidl_runtime_py.set_message": {"set_message_fields": set_message_fields},
    }
    made = {name: ModuleType(name) for name in contents}
    for name, content in contents.items():
        made[name].__dict__.update(content)
        parent, _, child = name.rpartition(".")
        if parent:
            setattr(made[parent], child, made[name])
    return made
