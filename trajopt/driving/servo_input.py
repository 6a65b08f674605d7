"""Orders to a servo, the loop that passes them on, and streams of orders in files.

A file, JSON or YAML, lists the orders by time:

    format: trajopt servo stream
    version: 1
    orders:
      - {at: 0.0, speed: 0.5}                                # speed factor
      - at: 0.0                                              # since the first tick [s]
        until: 0.8                                           # in every tick until then; once if omitted
        twist: {linear: [0, 0.1, 0], angular: [0, 0, 0], frame: world}  # [m/s], [rad/s]
      - {at: 0.81, until: 1.4, joints: {panda_joint1: 0.2}}   # [rad/s | m/s]
      - at: 1.41
        until: 2.5
        pose: {position: [0.4, 0, 0.5], orientation: [1, 0, 0, 0]}  # of the tool [m], (x, y, z, w)
      - {at: 2.51, released: the button was let go}

An order has at most one of `twist`, `joints`, `pose` and `released`, and `speed` if that changes. The parts
`linear` and `angular` of a twist default to 0, its `frame` to the world. A pose may have `rotation`, the rows
of a matrix, instead of `orientation`. A servo stops when its last command is older than its `timeout`, so a
lasting command needs `until`.
"""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np

from trajopt.driving.servo import Servo
from trajopt.driving.servo_command import Command, JointVelocities, Pose, Twist
from trajopt.values.arrays import Value, number, several
from trajopt.values.documents.document import Node, read_document, write_json
from trajopt.values.errors import FileFormatError, MissingExtra, ModelError, ProblemError, shown
from trajopt.values.errors.arguments import checked, checked_class
from trajopt.values.placement import WORLD, placement

if TYPE_CHECKING:
    from pygame._sdl2.controller import Controller

ROUNDING = 1e-9
"""Times closer than this are equal [s]."""
FORMAT, VERSION = "trajopt servo stream", 1
COMMANDS = ("twist", "joints", "pose", "released")
ZERO = (0.0, 0.0, 0.0)


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class Order(Value):
    """The input of a servo in one tick.

    Attributes:
        command: The command; None leaves the last one.
        speed: Speed factor of commands from now on, from 0 to 1; None leaves it.
        released: Reason to stop without a command; empty otherwise.
    """

    command: Command | None = None
    speed: float | None = None
    released: str = ""

    def __post_init__(self) -> None:
        if self.speed is not None and not 0.0 <= number("speed", self.speed) <= 1.0:
            raise ProblemError(f"speed must be from 0 to 1, is {self.speed:g}")
        if self.released and self.command is not None:
            raise ProblemError("an order cannot have both a command and a release; leave one out")

    @checked
    def give(self, servo: Servo) -> None:
        """Apply it to a servo."""
        if self.speed is not None:
            servo.slow_to(self.speed)
        if self.released:
            servo.release(self.released)
        if self.command is not None:
            servo.command(self.command)


@runtime_checkable
class ServoInput(Protocol):
    """A source of orders: a gamepad, a page in the browser, a recorded stream."""

    def read(self, since: float) -> Order | None:
        """Return the order at a time since the first tick [s], or None."""
        ...

    @property
    def done(self) -> bool:
        """Whether no further order will come."""
        ...

    def close(self) -> None:
        """Release its resources."""
        ...


@checked
def guide(
    servo: Servo,
    source: ServoInput,
    wait: Callable[[float], object],
    *,
    longest: float = inf,
    each: Callable[[Servo], object] | None = None,
) -> None:
    """Tick a servo with the orders of an input until they end and the robot is at rest.

    It also ends if the robot does not follow; the last event of the servo then gives the reason.

    Args:
        source: The input, which is not closed. `Recorder` records one.
        wait: Waits for a time [s]: `time.sleep` with a real arm, `arm.advance` with a simulated one.
    """
    executor, period = servo.executor, servo.options.period
    begun = executor.now()
    due = 0.0
    while (since := executor.now() - begun) < longest - ROUNDING and not (source.done and not servo.moving):
        order = source.read(since)
        if order is not None:
            order.give(servo)
        servo.tick()
        if each is not None:
            each(servo)
        if executor.fault():
            return
        # Missed ticks are skipped: several in a row would have the same effect as one.
        due = max(due + period, executor.now() - begun)
        wait(max(begun + due - executor.now(), 0.0))


@checked
@dataclass(frozen=True, eq=False)
class TimedOrder(Value):
    """An order with its times.

    Attributes:
        at: Time of its first tick, since the first tick of all [s].
        until: Time of its last tick; it is repeated in every tick between [s].
    """

    order: Order
    at: float
    until: float

    def __post_init__(self) -> None:
        begin, end = number("at", self.at), number("until", self.until)
        if not 0.0 <= begin <= end:
            raise ProblemError(
                f"times of an order must satisfy 0 <= at <= until; at {begin:g} s, until {end:g} s"
            )


@checked
@dataclass(frozen=True, eq=False)
class Stream(Value):
    """Orders in the order of time."""

    orders: Sequence[TimedOrder]

    def __post_init__(self) -> None:
        object.__setattr__(self, "orders", several("orders", self.orders, TimedOrder))
        for one, other in zip(self.orders, self.orders[1:], strict=False):
            if other.at < one.at:
                raise ProblemError(f"orders must be sorted by time; {other.at:g} s follows {one.at:g} s")

    @property
    def duration(self) -> float:
        return max((each.until for each in self.orders), default=0.0)

    @checked
    def write(self, path: Path | str) -> None:
        orders = [
            {
                "at": each.at,
                **({"until": each.until} if each.until > each.at else {}),
                **_document(each.order),
            }
            for each in self.orders
        ]
        write_json(path, {"format": FORMAT, "version": VERSION, "orders": orders})


@checked_class
class Player:
    """An input that repeats a stream."""

    def __init__(self, stream: Stream) -> None:
        self._stream, self._next, self._now = stream, 0, -1.0

    def read(self, since: float) -> Order | None:
        self._now = since
        orders, begun = self._stream.orders, self._next
        while self._next < len(orders) and orders[self._next].at <= since + ROUNDING:
            self._next += 1
        new = orders[begun : self._next]
        if new:
            speeds = [each.order.speed for each in new if each.order.speed is not None]
            last = new[-1].order
            return Order(command=last.command, speed=speeds[-1] if speeds else None, released=last.released)
        last = orders[self._next - 1] if self._next else None
        return last.order if last is not None and since <= last.until + ROUNDING else None

    @property
    def done(self) -> bool:
        return self._now >= self._stream.duration - ROUNDING

    def close(self) -> None:
        """Do nothing: no resource is open."""


@checked_class
class Recorder:
    """An input that records another one."""

    def __init__(self, source: ServoInput) -> None:
        self.source = source
        self._orders: list[TimedOrder] = []
        self._last: dict[str, object] | None = None

    def read(self, since: float) -> Order | None:
        order = self.source.read(since)
        document = None if order is None else _document(order)
        if order is not None and document == self._last:
            self._orders[-1] = TimedOrder(order, self._orders[-1].at, since)
        elif order is not None:
            self._orders.append(TimedOrder(order, since, since))
        self._last = document
        return order

    @property
    def done(self) -> bool:
        return self.source.done

    def close(self) -> None:
        self.source.close()

    @property
    def stream(self) -> Stream:
        """The recorded orders."""
        return Stream(tuple(self._orders))


@checked
def read_stream(path: Path | str) -> Stream:
    """Read a stream from a file.

    Raises:
        FileFormatError: If the file does not have the format of this module.
    """
    document = read_document(path).only(("format", "version", "orders"))
    if document["format"].text() != FORMAT:
        raise document["format"].error(f"is {shown(document['format'].text())}, must be {FORMAT!r}")
    if document["version"].number() != VERSION:
        raise document["version"].error(f"is {document['version'].number():g}, must be {VERSION}")
    orders: list[TimedOrder] = []
    for entry in document["orders"].elements():
        entry.only(("at", "until", "speed", *COMMANDS))
        try:
            orders.append(TimedOrder(_order(entry), at := entry["at"].number(), entry["until"].number(at)))
        except FileFormatError:
            raise
        except (ModelError, ProblemError) as error:
            raise entry.error(str(error)) from error
    try:
        return Stream(tuple(orders))
    except ProblemError as error:
        raise document["orders"].error(str(error)) from error


def _order(entry: Node) -> Order:
    given = [name for name in COMMANDS if not entry[name].missing]
    if len(given) > 1:
        raise entry.error(f"has {' and '.join(given)}; an order has at most one of them")
    return Order(
        command=_command(given[0], entry[given[0]]) if given and given[0] != "released" else None,
        speed=None if entry["speed"].missing else entry["speed"].number(),
        released=entry["released"].text(""),
    )


def _command(kind: str, node: Node) -> Command:
    match kind:
        case "twist":
            node.only(("linear", "angular", "frame"))
            linear, angular = (node[name].numbers() or ZERO for name in ("linear", "angular"))
            return Twist(np.array(linear), np.array(angular), node["frame"].text(WORLD))
        case "pose":
            node.only(("position", "orientation", "rotation"))
            if node["rotation"].missing == node["orientation"].missing:
                raise node.error("must have either an orientation or a rotation")
            if node["rotation"].missing:
                turned = placement(node["position"].numbers(), quaternion=node["orientation"].numbers())
            else:
                rows = [row.numbers() for row in node["rotation"].elements()]
                turned = placement(node["position"].numbers(), rotation=rows)
            return Pose(turned)
        case _:
            return JointVelocities({name: each.number() for name, each in node.members().items()})


def _document(order: Order) -> dict[str, object]:
    document: dict[str, object] = {} if order.speed is None else {"speed": order.speed}
    if order.released:
        document["released"] = order.released
    match order.command:
        case None:
            pass
        case Twist() as twist:
            axes = {"linear": twist.linear.tolist(), "angular": twist.angular.tolist(), "frame": twist.frame}
            document["twist"] = axes
        case Pose() as pose:
            where = pose.target
            # As a matrix, since a quaternion would round it.
            document["pose"] = {"position": where.translation.tolist(), "rotation": where.rotation.tolist()}
        case JointVelocities() as joints:
            document["joints"] = {name: float(value) for name, value in joints.velocities.items()}
    return document


FULL = 32767.0
"""Value of SDL for a stick at its end."""
NOTCH = 0.1
SLOWEST = 0.1
"""Least speed factor of the cross."""
RELEASED = "the button was let go"


@checked_class
class Gamepad:
    """A gamepad found by pygame.

    Buttons are named as on an Xbox pad.

    - LB, held: the robot follows; released, it stops (a dead man's button).
    - Left stick: up moves along x, left along y. Right stick: up moves along z, left turns about z.
    - RB, held in addition: the left stick turns, sideways about x and up about y, and does not move.
    - Cross, up and down: changes the speed factor by a tenth.

    The axes belong to the given frame. A stick at its end gives 1, which `ServoOptions.scaling` and `turning`
    convert to m/s and rad/s; `dead_zone` is a share of the stick's range.

    pygame has one state per process, which remains after `close`.
    """

    def __init__(self, number: int = 0, *, frame: str = WORLD) -> None:
        """Open it.

        Args:
            frame: Frame of the axes: "world", or the tool.

        Raises:
            MissingExtra: Without pygame-ce.
        """
        # Without a window there is no focus, without which SDL ignores pads.
        os.environ.setdefault("SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS", "1")
        os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
        try:
            import pygame
            from pygame._sdl2 import controller
        except ImportError as error:
            raise MissingExtra("pygame-ce", "gamepad") from error
        if not pygame.display.get_init():
            os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
            pygame.display.init()
        controller.init()
        pads = [index for index in range(controller.get_count()) if controller.is_controller(index)]
        if not 0 <= number < len(pads):
            have = f"SDL finds {len(pads)}, counted from 0" if pads else "SDL finds none"
            raise ProblemError(f"gamepad number {number} does not exist: {have}")
        self._pygame = pygame
        self._pad: Controller = controller.Controller(pads[number])
        self._frame, self._speed, self._cross = frame, 1.0, 0
        self.done = False

    @property
    def name(self) -> str:
        return self._pad.name

    def read(self, since: float) -> Order | None:
        pygame = self._pygame
        pygame.event.pump()
        if not self._pad.attached():
            self.done = True
            return Order(released="the gamepad is disconnected")
        speed = self._faster()
        if not self._held(pygame.CONTROLLER_BUTTON_LEFTSHOULDER):
            return Order(speed=speed, released=RELEASED)
        left, ahead = (
            -self._axis(each) for each in (pygame.CONTROLLER_AXIS_LEFTX, pygame.CONTROLLER_AXIS_LEFTY)
        )
        about, up = (
            -self._axis(each) for each in (pygame.CONTROLLER_AXIS_RIGHTX, pygame.CONTROLLER_AXIS_RIGHTY)
        )
        if self._held(pygame.CONTROLLER_BUTTON_RIGHTSHOULDER):
            # Right turns clockwise as seen from behind, as a hand turns a knob: about x.
            linear, angular = (0.0, 0.0, up), (-left, ahead, about)
        else:
            linear, angular = (ahead, left, up), (0.0, 0.0, about)
        return Order(command=Twist(np.array(linear), np.array(angular), self._frame), speed=speed)

    def close(self) -> None:
        self._pad.quit()

    def _faster(self) -> float | None:
        pygame = self._pygame
        cross = self._held(pygame.CONTROLLER_BUTTON_DPAD_UP) - self._held(pygame.CONTROLLER_BUTTON_DPAD_DOWN)
        pressed, self._cross = cross if cross != self._cross else 0, cross
        if not pressed:
            return None
        self._speed = round(min(max(self._speed + NOTCH * pressed, SLOWEST), 1.0), 3)
        return self._speed

    def _held(self, button: int) -> bool:
        return self._pad.get_button(button)

    def _axis(self, axis: int) -> float:
        return max(self._pad.get_axis(axis) / FULL, -1.0)
