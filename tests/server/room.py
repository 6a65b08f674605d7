"""Operations that misbehave, for tests of the service."""

import os
import signal
import time
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

import trajopt as to
from trajopt.server import Answer, Lane, Operation, SessionState, Watch
from trajopt.values.documents.document import Node


def echo(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Return what is given, and what is there."""
    return Answer({"given": arguments.value, "objects": sorted(state.scene.objects), "pid": os.getpid()})


def wait(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Wait until it is cancelled, telling of it."""
    watch.tell({"waits": True})
    cancelled = watch.cancel.wait(arguments["seconds"].number(60.0))
    return Answer({"cancelled": cancelled})


def stubborn(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Hear nothing."""
    watch.tell({"waits": True})
    time.sleep(60.0)
    return Answer({})


def die(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """End the process."""
    os.kill(os.getpid(), signal.SIGKILL)
    return Answer({})


def grow(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Take memory."""
    return Answer({"length": len(bytearray(int(arguments["bytes"].number())))})


HOARD = list[bytearray]()


def hoard(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Take memory, and never give it back."""
    HOARD.append(bytearray(int(arguments["bytes"].number())))
    return Answer({"length": len(HOARD[-1])})


def fault(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Have a fault that no client caused."""
    raise ZeroDivisionError("/etc/secret")


def add(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Add a sphere."""
    time.sleep(0.05)  # long enough for others to come in between
    scene = state.scene.add(arguments["name"].text(), to.Sphere(0.05), to.placement((1.5, 1.5, 0.0)))
    return Answer({"objects": sorted(scene.objects)}, replace(state, scene=scene))


def add_when_told(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Add a sphere once it is cancelled, and have the robot stand where it stood when this began."""
    watch.tell({"waits": True})
    watch.cancel.wait(60.0)
    return Answer({}, replace(state, scene=state.scene.add("late", to.Sphere(0.05), to.placement((2, 2, 0)))))


def move(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Have the robot be elsewhere, and stay under way until it is cancelled."""
    watch.tell({"moves": True}, list(arguments["to"].numbers()))
    watch.cancel.wait(60.0)
    return Answer({})


def brake(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Have the robot be on its way until it is cancelled, and roll on until the scene is another."""
    watch.tell({"moves": True}, list(arguments["to"].numbers()))
    watch.cancel.wait(60.0)
    until = time.monotonic() + 60.0
    while watch.changed() is None and time.monotonic() < until:
        time.sleep(0.01)
    return Answer({}, replace(state, positions=np.array(arguments["rest"].numbers())))


OPERATIONS: Mapping[str, Operation] = {
    "echo": Operation(echo, Lane.QUICK),
    "wait": Operation(wait),
    "stubborn": Operation(stubborn),
    "die": Operation(die),
    "grow": Operation(grow),
    "hoard": Operation(hoard),
    "fault": Operation(fault),
    "add": Operation(add, edits=True),
    "add_when_told": Operation(add_when_told, edits=True),
    "move": Operation(move, Lane.DRIVING),
    "brake": Operation(brake, Lane.DRIVING),
}
