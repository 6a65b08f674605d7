"""A gamepad drives a robot: SDL's virtual one, whose sticks and buttons the test moves."""

import ctypes
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.driving.test_servo import PERIOD, asked, led, tool
from trajopt.driving import (
    EventKind,
    Gamepad,
    Order,
    Player,
    Recorder,
    ServoOptions,
    Twist,
    guide,
    read_stream,
)
from trajopt.values.errors import ProblemError

KIND, AXES, BUTTONS, HATS = 1, 6, 21, 1
"""A gamepad as SDL knows them, so that it needs no mapping."""
LEFT_X, LEFT_Y, RIGHT_X, RIGHT_Y = range(4)
LB, RB, UP, DOWN = 9, 10, 11, 12
FULL = 32767


class Pad:
    """A gamepad of SDL's own, made of nothing."""

    def __init__(self) -> None:
        os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
        import pygame
        from pygame._sdl2 import controller

        pygame.display.init()
        controller.init()
        libraries = list((Path(pygame.__file__).parents[1] / "pygame_ce.libs").glob("libSDL2-2*"))
        if not libraries:
            pytest.skip("SDL is not where this test knows it to be")
        self.sdl = ctypes.CDLL(str(libraries[0]))
        self.sdl.SDL_JoystickOpen.restype = ctypes.c_void_p
        self.sdl.SDL_JoystickSetVirtualAxis.argtypes = (ctypes.c_void_p, ctypes.c_int, ctypes.c_int16)
        self.sdl.SDL_JoystickSetVirtualButton.argtypes = (ctypes.c_void_p, ctypes.c_int, ctypes.c_uint8)
        self.number = self.sdl.SDL_JoystickAttachVirtual(KIND, AXES, BUTTONS, HATS)
        assert self.number >= 0
        self.handle = self.sdl.SDL_JoystickOpen(self.number)

    def push(self, axis: int, share: float) -> None:
        self.sdl.SDL_JoystickSetVirtualAxis(self.handle, axis, round(FULL * share))

    def press(self, button: int, down: bool = True) -> None:
        self.sdl.SDL_JoystickSetVirtualButton(self.handle, button, int(down))

    def unplug(self) -> None:
        if self.handle:
            self.sdl.SDL_JoystickDetachVirtual(self.number)
            self.handle = None


@pytest.fixture
def pad() -> Iterator[Pad]:
    pytest.importorskip("pygame", reason="the extra `gamepad` is not installed")
    made = Pad()
    yield made
    made.unplug()


def twist(order: Order | None) -> tuple[list[float], list[float]]:
    assert order is not None and isinstance(order.command, Twist)
    return tuple(np.round(each, 3).tolist() for each in (order.command.linear, order.command.angular))


def test_sticks_give_the_twist(pad: Pad) -> None:
    gamepad = Gamepad(frame="panda_hand")
    silent = gamepad.read(0.0)
    assert silent is not None and silent.command is None and silent.released == "the button was let go"
    pad.press(LB)
    pad.push(LEFT_X, -0.5)
    pad.push(LEFT_Y, -1.0)
    pad.push(RIGHT_X, 0.25)
    pad.push(RIGHT_Y, 1.0)
    order = gamepad.read(0.0)
    assert twist(order) == ([1.0, 0.5, -1.0], [0.0, 0.0, -0.25])
    assert order is not None and isinstance(order.command, Twist) and order.command.frame == "panda_hand"
    pad.press(RB)
    assert twist(gamepad.read(0.0)) == ([0.0, 0.0, -1.0], [-0.5, 1.0, -0.25])
    gamepad.close()


def test_the_cross_sets_the_speed(pad: Pad) -> None:
    gamepad, speeds = Gamepad(), list[float | None]()
    for button, down in ((DOWN, True), (DOWN, True), (DOWN, False), (DOWN, True), (DOWN, False), (UP, True)):
        pad.press(button, down)
        order = gamepad.read(0.0)
        assert order is not None
        speeds.append(order.speed)
    assert speeds == [0.9, None, None, 0.8, None, 0.9]
    for _ in range(20):
        for down in (False, True):
            pad.press(UP, down)
            order = gamepad.read(0.0)
    assert order is not None and order.speed == 1.0
    gamepad.close()


def test_recorded_gamepad_gives_the_same_motion(pad: Pad, tmp_path: Path) -> None:
    problem = asked("panda")
    options = ServoOptions(period=PERIOD, scaling=0.2, dead_zone=0.05)
    arm, servo = led(problem, options)
    gamepad, begin = Gamepad(), tool(arm, servo).translation
    pad.push(LEFT_X, 0.04)  # never quite in the middle
    pad.push(LEFT_Y, -1.0)
    rows: list[np.ndarray] = []

    def each(_: object) -> None:
        rows.append(arm.committed(arm.now()))
        pad.press(LB, 0.1 < arm.now() < 0.7)
        if arm.now() > 1.0:
            pad.unplug()

    recorder = Recorder(gamepad)
    guide(servo, recorder, arm.advance, each=each)
    away = tool(arm, servo).translation - begin
    assert away[0] > 0.08 and np.abs(away[1:]).max() < 0.005
    assert [event.kind for event in servo.events] == [EventKind.STOPPING]
    assert servo.events[0].words == "the button was let go" and not servo.moving
    assert recorder.done and recorder.stream.orders[-1].order.released == "the gamepad is disconnected"
    gamepad.close()
    recorder.stream.write(tmp_path / "said.json")
    arm, servo = led(problem, options)
    again: list[np.ndarray] = []
    guide(
        servo,
        Player(read_stream(tmp_path / "said.json")),
        arm.advance,
        each=lambda _: again.append(arm.committed(arm.now())),
    )
    assert np.array_equal(np.array(again), np.array(rows))


def test_missing_gamepad_is_reported() -> None:
    pytest.importorskip("pygame", reason="the extra `gamepad` is not installed")
    with pytest.raises(ProblemError, match="gamepad number 7 does not exist"):
        Gamepad(7)


def test_pygame_is_imported_only_with_a_gamepad() -> None:
    code = "import sys, trajopt.driving; sys.exit('pygame' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(ImportError, match=r"trajopt-planner\[gamepad\]"):
        Gamepad()
