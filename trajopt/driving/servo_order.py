"""Orders to a servo: what one of its inputs says in a tick, and the loop that passes it on."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Protocol, runtime_checkable

from trajopt.driving.servo import Servo
from trajopt.driving.servo_command import Command
from trajopt.values.arrays import Value, number
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked

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
