"""Orders of a servo: passed on in ticks, recorded, written, and played with the same motion."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.driving.test_servo import PERIOD, asked, lead, led
from trajopt.driving import (
    EventKind,
    IdealExecutor,
    JointVelocities,
    Order,
    Player,
    Pose,
    Recorder,
    Servo,
    ServoInput,
    ServoOptions,
    SimulatedExecutor,
    Stream,
    TimedOrder,
    Twist,
    guide,
    read_stream,
)
from trajopt.values.arrays import Floats
from trajopt.values.errors import FileFormatError, ProblemError

FILE = """
format: trajopt servo stream
version: 1
orders:
  - {at: 0.0, speed: 0.5}
  - at: 0.0
    until: 0.3
    twist: {linear: [0, 0.1, 0], angular: [0, 0, 0.2], frame: panda_hand}
  - {at: 0.31, until: 0.5, joints: {panda_joint1: 0.2}}
  - {at: 0.51, until: 0.7, pose: {position: [0.4, 0, 0.5], orientation: [1, 0, 0, 0]}}
  - {at: 0.71, speed: 1, released: the button was let go}
"""


class Spoken:
    """An input that says what a function of the time does."""

    def __init__(self, until: float) -> None:
        self.until, self.now, self.closed = until, 0.0, False

    def read(self, since: float) -> Order | None:
        self.now = since
        if since > self.until:
            return None
        if since < 0.3:
            pushed = np.array((0.0, round(np.sin(9.0 * since), 2), -0.4))
            return Order(
                command=Twist(pushed, np.array((0.0, 0.0, 0.5))), speed=0.8 if since == 0.0 else None
            )
        if since < 0.5:
            return Order(command=JointVelocities({"panda_joint1": 0.3}))
        if since < 0.6:
            return Order(released="let go")
        return Order(command=Pose(to.placement((0.45, 0.1, 0.5), quaternion=(1.0, 0.1, 0.0, 0.0))))

    @property
    def done(self) -> bool:
        return self.now >= self.until

    def close(self) -> None:
        self.closed = True


def driven(source: ServoInput, arm: IdealExecutor | SimulatedExecutor, servo: Servo) -> Floats:
    """Lead an arm by an input; return where the joints had to be in each tick, (k, 3, n)."""
    rows: list[Floats] = []
    guide(servo, source, arm.advance, each=lambda _: rows.append(arm.committed(arm.now())))
    return np.array(rows)


@pytest.mark.parametrize("physics", [False, True])
def test_played_recording_gives_the_same_motion(tmp_path: Path, physics: bool) -> None:
    problem, options = asked("panda"), ServoOptions(period=PERIOD, scaling=0.2, smoothing=0.05)

    def fresh() -> tuple[IdealExecutor | SimulatedExecutor, Servo]:
        if not physics:
            return led(problem, options)
        arm = SimulatedExecutor(problem.scene, problem.start_positions)
        return arm, Servo(arm, problem, options)

    recorder = Recorder(Spoken(1.0))
    first, servo = fresh()
    before = driven(recorder, first, servo)
    assert not servo.moving and np.abs(before[:, 1]).max() > 0.05
    events = [(event.time, event.kind, event.words) for event in servo.events]
    assert [kind for _, kind, _ in events] == [EventKind.STOPPING, EventKind.STOPPING]
    recorder.stream.write(tmp_path / "orders.json")
    assert len(recorder.stream.orders) < 40
    for stream in (recorder.stream, read_stream(tmp_path / "orders.json")):
        arm, again = fresh()
        after = driven(Player(stream), arm, again)
        assert np.array_equal(after, before)
        assert [(event.time, event.kind, event.words) for event in again.events] == events


def test_stream_is_read_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "orders.yaml"
    path.write_text(FILE)
    stream = read_stream(path)
    assert stream.duration == 0.71
    first, twist, joints, pose, released = (each.order for each in stream.orders)
    assert (first.speed, first.command) == (0.5, None)
    assert isinstance(twist.command, Twist) and twist.command.frame == "panda_hand"
    assert twist.command.angular.tolist() == [0.0, 0.0, 0.2]
    assert isinstance(joints.command, JointVelocities) and joints.command.velocities == {"panda_joint1": 0.2}
    assert isinstance(pose.command, Pose) and pose.command.target.translation.tolist() == [0.4, 0.0, 0.5]
    assert (released.speed, released.released) == (1.0, "the button was let go")
    stream.write(tmp_path / "again.json")
    again = read_stream(tmp_path / "again.json")
    assert [(each.at, each.until) for each in again.orders] == [
        (each.at, each.until) for each in stream.orders
    ]
    arm, servo = led(asked("panda"))
    rows = driven(Player(stream), arm, servo)
    assert rows[40, 1, 0] == pytest.approx(0.1, abs=0.05), "at half speed"
    assert servo.events[-1].words == "the button was let go"


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ("", "must hold one mapping"),
        ("{format: other, version: 1, orders: []}", "format: is 'other'"),
        ("{format: trajopt servo stream, version: 2, orders: []}", "version: is 2, must be 1"),
        ("{format: trajopt servo stream, version: 1, order: []}", "did you mean 'orders'"),
    ],
)
def test_refuses_files_without_a_stream(tmp_path: Path, wrong: str, message: str) -> None:
    path = tmp_path / "orders.yaml"
    path.write_text(wrong)
    with pytest.raises(FileFormatError, match=message):
        read_stream(path)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("{at: 0, twist: {}, joints: {a: 1}}", "has twist and joints"),
        ("{at: 0, twist: {linear: [0, 0]}}", r"orders\[1\].*linear"),
        ("{at: 0, twist: {linaer: [0, 0, 0]}}", "did you mean 'linear'"),
        ("{at: 0, pose: {position: [0, 0, 0], orientation: [0, 0, 0, 0]}}", r"orders\[1\]"),
        ("{at: 0, pose: {position: [0, 0, 0]}}", "an orientation or a rotation"),
        ("{at: 0, pose: {position: [0, 0, 0], rotation: [[1, 0, 0], [0, 1, 0]]}}", r"orders\[1\]"),
        ("{at: 0, joints: {a: b}}", "joints.a: must be a number"),
        ("{at: 0, speed: 2}", "speed must be from 0 to 1"),
        ("{at: -1, speed: 1}", "must satisfy 0 <= at"),
        ("{at: 1, until: 0.5, speed: 1}", "at <= until"),
        ("{at: 1, sped: 1}", "did you mean 'speed'"),
        ("{at: 0.1, speed: 1}", "sorted by time"),
    ],
)
def test_errors_of_entries_are_named(tmp_path: Path, entry: str, message: str) -> None:
    path = tmp_path / "orders.yaml"
    first = "{at: 0.2, speed: 1}"
    path.write_text(f"format: trajopt servo stream\nversion: 1\norders:\n  - {first}\n  - {entry}\n")
    with pytest.raises(FileFormatError, match=message) as caught:
        read_stream(path)
    assert str(caught.value).count("orders.yaml") == 1


def test_order_has_a_command_or_a_release() -> None:
    with pytest.raises(ProblemError, match="both a command and a release"):
        Order(command=Twist(), released="let go")
    with pytest.raises(ProblemError, match="speed"):
        Order(speed=-0.1)


def test_release_stops_before_the_timeout() -> None:
    rest: list[float] = []
    for order in (Order(released="let go"), None):
        arm, servo = led(asked("panda"))
        lead(arm, servo, Twist((0.0, 0.2, 0.0)), 0.6)
        began = arm.now()
        while servo.moving:
            if order is not None:
                order.give(servo)
            servo.tick()
            arm.advance(PERIOD)
        rest.append(arm.now() - began)
        assert [event.kind for event in servo.events] == [EventKind.STOPPING]
    assert rest[0] < rest[1] - 0.05


def test_missed_ticks_are_skipped() -> None:
    """The input is read at the time that it is, however long a tick took."""
    arm, servo = led(asked("panda"))
    seen: list[float] = []

    class Listening(Spoken):
        def read(self, since: float) -> Order | None:
            seen.append(since)
            return super().read(since)

    guide(servo, Listening(0.2), lambda seconds: arm.advance(seconds + 0.015), longest=0.4)
    assert (np.diff(seen) > 0.014).all() and seen[-1] < 0.4


def test_fault_ends_guide() -> None:
    arm, servo = led(asked("panda"))

    def off(_: Servo) -> None:
        if arm.now() > 0.1:
            arm.displace(np.full(7, 0.1))

    guide(servo, Spoken(1.0), arm.advance, each=off)
    assert servo.events[-1].kind is EventKind.OFF_TRACK and arm.now() < 0.3


def test_a_stream_out_of_order_is_refused() -> None:
    orders = [TimedOrder(Order(speed=1.0), at, at) for at in (0.2, 0.1)]
    with pytest.raises(ProblemError, match="sorted by time"):
        Stream(orders)
