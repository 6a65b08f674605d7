"""Stand-in for the part of `rospy` that MoveIt's scripts use, without a node; time is wall time."""

import logging
import sys
import time
from collections.abc import Callable, Sequence
from math import inf
from typing import Any

from trajopt.files.messages import (
    AttachedCollisionObject,
    CollisionObject,
    DisplayTrajectory,
    PlanningScene,
    field_names,
    is_message,
)
from trajopt.files.messages import Duration as Duration
from trajopt.files.messages import Time as Time
from trajopt.ros.commander.planning_scene_interface import PlanningSceneInterface
from trajopt.ros.commander.world import current_world, world_or_current
from trajopt.server.move_group.outcome import MoveItCommanderException
from trajopt.values.errors import shown

DEBUG, INFO, WARN, ERROR, FATAL = 1, 2, 4, 8, 16

_LOG = logging.getLogger("trajopt.ros.commander")


class ROSException(Exception):
    """Never raised; here so that scripts may catch it."""


class ROSInterruptException(ROSException):
    """Never raised; here so that scripts may catch it."""


class Rate:
    """Runs a loop at a fixed rate."""

    def __init__(self, hz: float, reset: bool = False) -> None:
        """Start the first period of 1 / `hz` [s] now."""
        self.sleep_dur = Duration(1.0 / hz)
        self._begun = time.monotonic()

    def remaining(self) -> Duration:
        """Return the rest of the period; 0 if it is over."""
        left = self._begun + self.sleep_dur.to_sec() - time.monotonic()
        return Duration(max(left, 0.0))

    def sleep(self) -> None:
        """Sleep until the period ends, and start the next."""
        left = self.remaining().to_sec()
        time.sleep(left)
        round_length = self.sleep_dur.to_sec()
        self._begun = self._begun + round_length if left > 0.0 else time.monotonic()


def init_node(
    name: str, argv: Sequence[str] | None = None, anonymous: bool = False, log_level: int = INFO, **_: object
) -> None:
    """Record the script's name; other arguments are as in ROS, and ignored."""
    world = current_world()
    if world is not None:
        world.node.name = name


def get_name() -> str:
    return f"/{world_or_current(None).node.name}"


def myargv(argv: Sequence[str] | None = None) -> list[str]:
    """Return the arguments of the script without those that map names (`a:=b`)."""
    return [word for word in (sys.argv if argv is None else argv) if ":=" not in word]


def is_shutdown() -> bool:
    """Return whether `signal_shutdown` was called; the script itself decides when to end."""
    world = current_world()
    return world is not None and world.node.shut_down


def signal_shutdown(reason: str) -> None:
    _LOG.info("shutdown: %s", reason)
    world_or_current(None).node.end()


def on_shutdown(h: Callable[[], object]) -> None:
    world_or_current(None).node.hooks.append(h)


def spin() -> None:
    """Return immediately; no messages arrive."""
    _LOG.info("rospy.spin() returns: nothing is received in a simulated world")


def has_param(param_name: str) -> bool:
    return world_or_current(None).node.has(param_name)


def search_param(param_name: str) -> str | None:
    return f"/{param_name.removeprefix('/')}" if has_param(param_name) else None


def get_param(param_name: str, *default: object) -> object:
    node = world_or_current(None).node
    return default[0] if default and not node.has(param_name) else node.parameter(param_name)


def set_param(param_name: str, param_value: object) -> None:
    world_or_current(None).node.parameters[param_name.removeprefix("/")] = param_value


def get_time() -> float:
    return time.time()


get_rostime = Time.now


def sleep(duration: float | Duration) -> None:
    """Sleep for a duration [s]; a motion started with `wait=False` continues."""
    time.sleep(duration if isinstance(duration, int | float) else duration.to_sec())


def logdebug(msg: str, *args: object) -> None:
    _LOG.debug(msg, *args)


def loginfo(msg: str, *args: object) -> None:
    _LOG.info(msg, *args)


def logwarn(msg: str, *args: object) -> None:
    _LOG.warning(msg, *args)


def logerr(msg: str, *args: object) -> None:
    _LOG.error(msg, *args)


def logfatal(msg: str, *args: object) -> None:
    _LOG.critical(msg, *args)


def _repeated(log: Callable[..., None], period: float, msg: str, *args: object) -> None:
    """Log a text unless it was logged within a period [s]."""
    last, now = _LOGGED.get((log.__name__, msg)), time.monotonic()
    if last is None or now - last >= period:
        _LOGGED[log.__name__, msg] = now
        log(msg, *args)


_LOGGED: dict[tuple[str, str], float] = {}


def loginfo_once(msg: str, *args: object) -> None:
    _repeated(loginfo, inf, msg, *args)


def logwarn_once(msg: str, *args: object) -> None:
    _repeated(logwarn, inf, msg, *args)


def logerr_once(msg: str, *args: object) -> None:
    _repeated(logerr, inf, msg, *args)


def loginfo_throttle(period: float, msg: str, *args: object) -> None:
    """Log a text at most once in a period [s]."""
    _repeated(loginfo, period, msg, *args)


def logwarn_throttle(period: float, msg: str, *args: object) -> None:
    """Log a text at most once in a period [s]."""
    _repeated(logwarn, period, msg, *args)


def logerr_throttle(period: float, msg: str, *args: object) -> None:
    """Log a text at most once in a period [s]."""
    _repeated(logerr, period, msg, *args)


class Publisher:
    """Publishes messages of one type.

    `CollisionObject`, `AttachedCollisionObject` and `PlanningScene` change the world's scene; others are
    logged.
    """

    def __init__(self, name: str, data_class: type, *_: object, **__: object) -> None:
        """Select a topic and its type; further arguments (`queue_size`, `latch`) are ignored."""
        self.name = name
        self.data_class = data_class
        self._world = world_or_current(None)

    def get_num_connections(self) -> int:
        """Return 1: the log."""
        return 1

    def unregister(self) -> None:
        """Do nothing; there is no ROS master."""

    def publish(self, *args: Any, **fields: Any) -> None:
        """Log a message, or apply it to the scene."""
        whole = len(args) == 1 and not fields and _is_message(args[0], self.data_class)
        alone = args[0] if whole else None
        kind = self.data_class.__name__
        if alone is not None and type(alone).__name__ != kind:
            raise MoveItCommanderException(
                f"topic {shown(self.name)} takes {kind}, not {type(alone).__name__}"
            )
        message = self.data_class(*args, **fields) if alone is None else alone
        scene = PlanningSceneInterface(world=self._world)
        match message:
            case CollisionObject():
                scene.add_object(message)
            case AttachedCollisionObject():
                scene.process_attached(message)
            case PlanningScene():
                scene.apply_planning_scene(message)
            case _:
                pass
        _LOG.info("%s: %s", self.name, _told(message))


def _is_message(value: object, kind: type) -> bool:
    return isinstance(value, kind) or bool(field_names(value))


def _told(message: Any) -> str:
    if not isinstance(message, DisplayTrajectory) or not all(
        is_message(each, "joint_trajectory") for each in message.trajectory
    ):
        return shown(message)
    told: list[str] = []
    for each in message.trajectory:
        motion = each.joint_trajectory
        seconds = motion.points[-1].time_from_start.to_sec() if motion.points else 0.0
        told.append(f"{len(motion.points)} points of {len(motion.joint_names)} joints, {seconds:.2f} s")
    return f"DisplayTrajectory: {'; '.join(told) or 'no trajectory'}"
