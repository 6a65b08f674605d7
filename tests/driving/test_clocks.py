"""Stamps of clocks that are ahead: refused beyond a tolerance, within it they count as now."""

import re

import numpy as np
import pytest

import trajopt as to
from tests.driving.test_clouds_seen import seen
from tests.driving.test_servo import PERIOD, asked, kinds, led
from tests.driving.test_supervisor import in_the_way, problem, run, supervised
from trajopt.driving import EventKind, ServoOptions, SupervisorOptions, Twist
from trajopt.values.errors import ClockError, ProblemError, ShapeError

__all__ = ["problem"]  # a fixture
ASIDE = Twist(np.array((0.0, 0.1, 0.0)))


def crossing(problem: to.Problem) -> to.Scene:
    """A box that is in the robot's way at 0 s and elsewhere a second before and after."""
    times = (-1.0, 0.0, 1.0)
    track = to.Track.through(times, [to.placement((0.44, 2.0 * time, 0.25)) for time in times])
    return problem.scene.add("crate", to.Box(0.1, 0.1, 0.1), motion=track)


def test_scene_stamped_ahead_is_refused_and_changes_nothing(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    run(arm, supervisor, 0.2)
    before, events = supervisor.world, len(supervisor.events)
    words = (
        "stamp 1.200 s is 1.000 s ahead of the executor's clock, which shows 0.200 s; "
        "clock_tolerance is 0.01 s; correct the clock of the sender, or stamp by executor.now()"
    )
    with pytest.raises(ClockError, match=re.escape(words)):
        supervisor.see(crossing(problem), arm.now() + 1.0)
    assert supervisor.world is before and len(supervisor.events) == events
    run(arm, supervisor, 10.0)
    assert supervisor.events[-1].kind is EventKind.REACHED


def test_scene_stamped_a_little_ahead_counts_as_now(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    run(arm, supervisor, 0.2)
    supervisor.see(crossing(problem), arm.now() + 0.009)
    assert supervisor.world.stamp == arm.now()


def test_refused_cloud_does_not_block_later_clouds(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    run(arm, supervisor, 0.2)
    with pytest.raises(ClockError, match=r"60\.000 s ahead"):
        supervisor.see_cloud("camera", None, arm.now() + 60.0)
    assert "camera" not in supervisor.scene.objects
    run(arm, supervisor, 0.24)
    wall = seen(in_the_way(problem), "surprise")
    assert supervisor.see_cloud("camera", wall, arm.now() - 0.01)
    assert supervisor.scene.objects["camera"].parts[0][0] is wall


def test_clouds_count_after_the_clock_is_set_back(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    arm.advance(60.0)
    assert supervisor.see_cloud("camera", None)
    arm.advance(-50.0)
    wall = seen(in_the_way(problem), "surprise")
    assert supervisor.see_cloud("camera", wall)
    assert not supervisor.see_cloud("camera", None, arm.now() - 0.1)
    assert supervisor.scene.objects["camera"].parts[0][0] is wall


def test_cloud_stamped_a_little_ahead_counts_as_now(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    assert supervisor.see_cloud("camera", None, arm.now() + 0.005)
    arm.advance(0.001)
    assert supervisor.see_cloud("camera", None, arm.now())


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_stamp_that_is_not_finite_is_refused(problem: to.Problem, wrong: float) -> None:
    _, supervisor = supervised(problem)
    for see in (
        lambda: supervisor.see(problem.scene, wrong),
        lambda: supervisor.see_cloud("camera", None, wrong),
    ):
        with pytest.raises(ShapeError, match="stamp"):
            see()


def test_command_stamped_ahead_does_not_outlive_its_sender() -> None:
    arm, servo = led(asked("panda"), ServoOptions(period=PERIOD, timeout=0.1))
    for _ in range(20):
        servo.command(ASIDE, arm.now())
        servo.tick()
        arm.advance(PERIOD)
    gone = arm.now()
    with pytest.raises(ClockError, match=r"60\.000 s ahead"):
        servo.command(ASIDE, gone + 60.0)
    while servo.moving:
        servo.tick()
        arm.advance(PERIOD)
    assert kinds(servo) == [EventKind.STOPPING]
    assert servo.events[0].time < gone + 0.1 + PERIOD


def test_command_stamped_a_little_ahead_counts_as_now() -> None:
    arm, servo = led(asked("panda"), ServoOptions(period=PERIOD, timeout=0.1))
    servo.command(ASIDE, arm.now() + 0.009)
    said = arm.now()
    while not kinds(servo):
        servo.tick()
        arm.advance(PERIOD)
    assert said + 0.1 < servo.events[0].time < said + 0.1 + 1.5 * PERIOD


def test_command_does_not_outlive_its_sender_where_the_clock_is_set_back() -> None:
    arm, servo = led(asked("panda"), ServoOptions(period=PERIOD, timeout=0.1))
    for _ in range(20):
        servo.command(ASIDE, arm.now())
        servo.tick()
        arm.advance(PERIOD)
    end = servo.committed.end
    arm.advance(-5.0)
    for _ in range(int(6.0 / PERIOD)):
        servo.tick()
        arm.advance(PERIOD)
    assert servo.committed.end == end
    assert [str(event.words) for event in servo.events] == ["the executor's clock was set back"]


def test_scene_of_a_servo_stamped_ahead_is_refused() -> None:
    arm, servo = led(asked("panda"), ServoOptions(period=PERIOD))
    before = servo.world
    with pytest.raises(ClockError, match="ahead of the executor's clock"):
        servo.see(servo.scene, arm.now() + 0.1)
    assert servo.world is before and servo.events == []


def test_clock_tolerance_can_be_stated() -> None:
    arm, servo = led(asked("panda"), ServoOptions(period=PERIOD, clock_tolerance=0.2))
    servo.see(servo.scene, arm.now() + 0.1)
    assert servo.world.stamp == arm.now()
    for options in (ServoOptions, SupervisorOptions):
        with pytest.raises(ProblemError, match="clock_tolerance"):
            options(clock_tolerance=-1.0)
