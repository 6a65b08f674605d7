"""Stand-in for the parts of `rclpy`, `rclcpp` and `py_binding_tools` that MoveIt's scripts use."""

import logging as _logging
from functools import partialmethod
from types import SimpleNamespace

from trajopt.ros.commander.world import current_world

_LOG = _logging.getLogger("trajopt.ros.commander")


def init(*_: object, **__: object) -> None:
    """Do nothing; no middleware is used."""


roscpp_init = init


class Node:
    """A name without communication, as `rclcpp.Node`."""

    def __init__(self, name: str, *_: object, **__: object) -> None:
        self.name = name


def ok(*_: object) -> bool:
    world = current_world()
    return world is None or not world.node.shut_down


def shutdown(*_: object, **__: object) -> None:
    world = current_world()
    if world is not None:
        world.node.end()


def spin(*_: object, **__: object) -> None:
    """Return immediately; no messages arrive."""
    _LOG.info("rclpy.spin() returns: nothing is received in a simulated world")


class Logger:
    """A logger that prefixes its lines with a name."""

    def __init__(self, name: str) -> None:
        self.name = name

    def _log(self, level: int, message: str, **_: object) -> None:
        _LOG.log(level, "%s: %s", self.name, message)

    debug = partialmethod(_log, _logging.DEBUG)
    info = partialmethod(_log, _logging.INFO)
    warning = warn = partialmethod(_log, _logging.WARNING)
    error = partialmethod(_log, _logging.ERROR)
    fatal = partialmethod(_log, _logging.CRITICAL)


get_logger = Logger
logging = SimpleNamespace(get_logger=get_logger)
