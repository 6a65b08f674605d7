"""Streams of orders to a servo: recorded, written, read, and played again.

A file, JSON or YAML, lists what was said, in order:

    format: trajopt servo stream
    version: 1
    orders:
      - {at: 0.0, speed: 0.5}                                # the slider
      - at: 0.0                                              # since the first tick [s]
        until: 0.8                                           # in every tick until then; once where left out
        twist: {linear: [0, 0.1, 0], angular: [0, 0, 0], frame: world}  # [m/s], [rad/s]
      - {at: 0.81, until: 1.4, joints: {panda_joint1: 0.2}}   # [rad/s | m/s]
      - at: 1.41
        until: 2.5
        pose: {position: [0.4, 0, 0.5], orientation: [1, 0, 0, 0]}  # of the tool [m], (x, y, z, w)
      - {at: 2.51, released: the button was let go}

An order has one of `twist`, `joints`, `pose` and `released`, or none, and `speed` if that changes. Of a twist
`linear` and `angular` are 0 and `frame` the world where left out; of a pose the rows of a matrix, `rotation`,
will do for `orientation`. A servo stops when its last command is older than its `timeout`, so what is meant
to last needs `until`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np

from trajopt.driving.servo import Servo
from trajopt.driving.servo_command import Command, JointVelocities, Pose, Twist
from trajopt.values.arrays import Value, number, several
from trajopt.values.documents.document import Node, read_document
from trajopt.values.documents.json_files import write_json
from trajopt.values.errors import ModelError, ProblemError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD, placement

ROUNDING = 1e-9
"""Times nearer than this are one [s]."""


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class Order(Value):
    """What is said to a servo in one tick.

    Attributes:
        command: What the robot is to do; None says nothing about it.
        speed: The part of its speed at which commands are followed from now on, from 0 to 1; None leaves it.
        released: Why nobody leads the robot any more, in words; empty if somebody does.
    """

    command: Command | None = None
    speed: float | None = None
    released: str = ""

    def __post_init__(self) -> None:
        """Check that it is not said to go and to stop at once.

        Raises:
            ProblemError: If it is, or the speed is not from 0 to 1.
        """
        if self.speed is not None and not 0.0 <= number("speed", self.speed) <= 1.0:
            raise ProblemError(f"speed is from 0 to 1, is {self.speed:g}")
        if self.released and self.command is not None:
            raise ProblemError("an order has a command, or releases the robot; this one does both")

    @checked
    def give(self, servo: Servo) -> None:
        """Pass it on.

        Raises:
            JointNotFound: If a joint of the command is not the group's.
            FrameNotFound: If there is no such frame.
        """
        if self.speed is not None:
            servo.slow_to(self.speed)
        if self.released:
            servo.release(self.released)
        if self.command is not None:
            servo.command(self.command)


@runtime_checkable
class ServoInput(Protocol):
    """Something by which a robot is led: a gamepad, a page in the browser, what was recorded."""

    def read(self, since: float) -> Order | None:
        """Return what is said in this tick; None if nothing is.

        Args:
            since: Time since the first tick [s].
        """
        ...

    @property
    def done(self) -> bool:
        """Whether nothing more will be said."""
        ...

    def close(self) -> None:
        """Let go of what it reads."""
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
    """Tick a servo and pass on what an input says, until nothing more is said and the robot stands.

    It ends too where the robot does not follow: the last of the servo's events says why.

    Args:
        servo: The servo.
        source: What it is led by. It is not closed. `Recorder` remembers what one says.
        wait: Lets so much time pass [s]: `time.sleep` with a real arm, `arm.advance` with a simulated one.
        longest: Most time [s].
        each: Called after each tick: for a view.
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
        # Ticks that came too late are left out: several at once would say the same.
        due = max(due + period, executor.now() - begun)
        wait(max(begun + due - executor.now(), 0.0))


FORMAT, VERSION = "trajopt servo stream", 1
COMMANDS = ("twist", "joints", "pose", "released")
STILL = (0.0, 0.0, 0.0)


@checked
@dataclass(frozen=True, eq=False)
class TimedOrder(Value):
    """An order, and when it was said.

    Attributes:
        order: The order.
        at: First, since the first tick [s].
        until: Last: it was said in every tick between [s].
    """

    order: Order
    at: float
    until: float

    def __post_init__(self) -> None:
        """Check the times.

        Raises:
            ProblemError: If it was said before the first tick, or last before it was said first.
        """
        begin, end = number("at", self.at), number("until", self.until)
        if not 0.0 <= begin <= end:
            raise ProblemError(
                f"an order is said from 0 on, and until later; at {begin:g} s, until {end:g} s"
            )


@checked
@dataclass(frozen=True, eq=False)
class Stream(Value):
    """What was said to a servo.

    Attributes:
        said: In the order of time.
    """

    said: Sequence[TimedOrder]

    def __post_init__(self) -> None:
        """Check the order.

        Raises:
            ProblemError: If one was said before the one before it in the list.
        """
        object.__setattr__(self, "said", several("said", self.said, TimedOrder))
        for one, other in zip(self.said, self.said[1:], strict=False):
            if other.at < one.at:
                raise ProblemError(f"orders are in the order of time; {other.at:g} s is after {one.at:g} s")

    @property
    def duration(self) -> float:
        """When the last order was said [s]; 0 if there is none."""
        return max((each.until for each in self.said), default=0.0)

    @checked
    def write(self, path: Path | str) -> None:
        """Write it as JSON; the module says how.

        Raises:
            FileFormatError: If it cannot be written.
        """
        orders = [
            {"at": each.at, **({"until": each.until} if each.until > each.at else {}), **_told(each.order)}
            for each in self.said
        ]
        write_json(path, {"format": FORMAT, "version": VERSION, "orders": orders})


class Player:
    """A stream as an input: it says again what was said, in the same ticks."""

    @checked
    def __init__(self, stream: Stream) -> None:
        """Begin at its beginning."""
        self._stream, self._next, self._now = stream, 0, -1.0

    @checked
    def read(self, since: float) -> Order | None:
        """Return what was said at this time; the last where orders are nearer to each other than ticks."""
        self._now = since
        said, begun = self._stream.said, self._next
        while self._next < len(said) and said[self._next].at <= since + ROUNDING:
            self._next += 1
        new = said[begun : self._next]
        if new:
            speeds = [each.order.speed for each in new if each.order.speed is not None]
            last = new[-1].order
            return Order(command=last.command, speed=speeds[-1] if speeds else None, released=last.released)
        last = said[self._next - 1] if self._next else None
        return last.order if last is not None and since <= last.until + ROUNDING else None

    @property
    def done(self) -> bool:
        """Whether all was said."""
        return self._now >= self._stream.duration - ROUNDING

    def close(self) -> None:
        """Nothing is open."""


class Recorder:
    """An input that remembers what another one says.

    Attributes:
        source: The other one.
    """

    @checked
    def __init__(self, source: ServoInput) -> None:
        """Listen."""
        self.source = source
        self._said: list[TimedOrder] = []
        self._last: dict[str, object] | None = None

    @checked
    def read(self, since: float) -> Order | None:
        """Return what is said in this tick."""
        order = self.source.read(since)
        told = None if order is None else _told(order)
        if order is not None and told == self._last:
            self._said[-1] = TimedOrder(order, self._said[-1].at, since)
        elif order is not None:
            self._said.append(TimedOrder(order, since, since))
        self._last = told
        return order

    @property
    def done(self) -> bool:
        """Whether nothing more will be said."""
        return self.source.done

    def close(self) -> None:
        """Let go of what the other one reads."""
        self.source.close()

    @property
    def stream(self) -> Stream:
        """What was said until now."""
        return Stream(tuple(self._said))


@checked
def read_stream(path: Path | str) -> Stream:
    """Read a stream from a file; the module says what it holds.

    Raises:
        FileFormatError: If the file does not say what it must.
    """
    document = read_document(path).only(("format", "version", "orders"))
    if document["format"].text() != FORMAT:
        raise document["format"].error(f"is {shown(document['format'].text())}, must be {FORMAT!r}")
    if document["version"].number() != VERSION:
        raise document["version"].error(f"is {document['version'].number():g}; this reads version {VERSION}")
    said: list[TimedOrder] = []
    for entry in document["orders"].elements():
        entry.only(("at", "until", "speed", *COMMANDS))
        try:
            said.append(TimedOrder(_order(entry), at := entry["at"].number(), entry["until"].number(at)))
        except (ModelError, ProblemError) as error:
            raise entry.error(str(error)) from error
    try:
        return Stream(tuple(said))
    except ProblemError as error:
        raise document["orders"].error(str(error)) from error


def _order(entry: Node) -> Order:
    given = [name for name in COMMANDS if not entry[name].missing]
    if len(given) > 1:
        raise entry.error(f"says {' and '.join(given)} at once")
    return Order(
        command=_command(given[0], entry[given[0]]) if given and given[0] != "released" else None,
        speed=None if entry["speed"].missing else entry["speed"].number(),
        released=entry["released"].text(""),
    )


def _command(kind: str, node: Node) -> Command:
    match kind:
        case "twist":
            node.only(("linear", "angular", "frame"))
            linear, angular = (node[name].numbers() or STILL for name in ("linear", "angular"))
            return Twist(np.array(linear), np.array(angular), node["frame"].text(WORLD))
        case "pose":
            node.only(("position", "orientation", "rotation"))
            if node["rotation"].missing == node["orientation"].missing:
                raise node.error("has an orientation or a rotation, one of both")
            if node["rotation"].missing:
                turned = placement(node["position"].numbers(), quaternion=node["orientation"].numbers())
            else:
                rows = [row.numbers() for row in node["rotation"].elements()]
                turned = placement(node["position"].numbers(), rotation=rows)
            return Pose(turned)
        case _:
            return JointVelocities({name: each.number() for name, each in node.members().items()})


def _told(order: Order) -> dict[str, object]:
    """Return an order as plain data."""
    told: dict[str, object] = {} if order.speed is None else {"speed": order.speed}
    if order.released:
        told["released"] = order.released
    match order.command:
        case None:
            pass
        case Twist() as twist:
            axes = {"linear": twist.linear.tolist(), "angular": twist.angular.tolist(), "frame": twist.frame}
            told["twist"] = axes
        case Pose() as pose:
            where = pose.target
            # As a matrix, for a quaternion would round it.
            told["pose"] = {"position": where.translation.tolist(), "rotation": where.rotation.tolist()}
        case JointVelocities() as joints:
            told["joints"] = {name: float(value) for name, value in joints.velocities.items()}
    return told
