"""Stand-in for the part of `rclpy` that MoveIt 2's scripts use, without a node or subscriptions."""

import logging as _logging

from trajopt.ros.commander.rclpy import logging as logging
from trajopt.ros.commander.world import current_world

_LOG = _logging.getLogger("trajopt.ros.commander")


def init(*_: object, **__: object) -> None:
    """Do nothing; no middleware is used."""


def ok(*_: object) -> bool:
    """Return whether `shutdown` has not been called."""
    world = current_world()
    return world is None or not world.node.shut_down


def shutdown(*_: object, **__: object) -> None:
    """Make `ok` return False from now on."""
    world = current_world()
    if world is not None:
        world.node.end()


def spin(*_: object, **__: object) -> None:
    """Return immediately; no messages arrive."""
    _LOG.info("rclpy.spin() returns: nothing is received in a simulated world")
