"""Stands for the part of `rclpy` that MoveIt 2's scripts call: there is no node, and nothing is received."""

import logging as _logging

from trajopt.ros.commander.rclpy import logging as logging
from trajopt.ros.commander.world import current_world

_LOG = _logging.getLogger("trajopt.ros.commander")


def init(*_: object, **__: object) -> None:
    """Do nothing: there is no middleware to start."""


def ok(*_: object) -> bool:
    """Return whether `shutdown` was not called yet."""
    world = current_world()
    return world is None or not world.node.shut_down


def shutdown(*_: object, **__: object) -> None:
    """Let `ok` be False from now on."""
    world = current_world()
    if world is not None:
        world.node.end()


def spin(*_: object, **__: object) -> None:
    """Return: nothing would ever come in."""
    _LOG.info("rclpy.spin() returns: nothing is received in a simulated world")
