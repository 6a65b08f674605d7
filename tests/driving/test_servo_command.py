"""Shaping of commands: each option, for each kind of command."""

from math import exp

import numpy as np
import pytest

import trajopt as to
from tests.driving.test_servo import PERIOD, asked, kinds, lead, led, tool
from trajopt.driving import Axis, EventKind, JointVelocities, Pose, ServoOptions, Twist
from trajopt.driving.servo_task import values_of
from trajopt.values.errors import ProblemError

PUSHED = Twist((0.05, -0.3, 1.0), (0.0, 0.6, -0.1))
JOINTS = JointVelocities({"panda_joint1": 0.3, "panda_joint4": -0.05})


def shaped(command: Twist | JointVelocities, **options: object) -> list[float]:
    values = values_of(command, asked("panda").reduced, ServoOptions(**options))  # pyright: ignore
    return np.round(values, 6).tolist()


def test_dead_zone_is_subtracted_from_each_number() -> None:
    assert shaped(PUSHED, dead_zone=0.1) == [0.0, -0.2, 0.9, 0.0, 0.5, 0.0]
    assert shaped(JOINTS, dead_zone=0.1) == [0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    edge = Twist((0.1 + 1e-6, 0.0, 0.0))
    assert shaped(edge, dead_zone=0.1)[0] == pytest.approx(1e-6), "nothing jumps where it ends"


def test_commands_are_scaled_after_the_dead_zone() -> None:
    assert shaped(PUSHED, dead_zone=0.1, scaling=2.0) == [0.0, -0.4, 1.8, 0.0, 1.0, 0.0]
    assert shaped(PUSHED, scaling=2.0, turning=3.0) == [0.1, -0.6, 2.0, 0.0, 3.6, -0.6]
    assert shaped(JOINTS, scaling=2.0, turning=3.0)[0] == 0.6


@pytest.mark.parametrize("axis", Axis)
def test_locked_axis_has_no_effect(axis: Axis) -> None:
    values = shaped(PUSHED, locked=(axis,))
    assert values[axis.value] == 0.0
    assert np.delete(values, axis.value).tolist() == np.delete(shaped(PUSHED), axis.value).tolist()
    assert shaped(JOINTS, locked=tuple(Axis)) == shaped(JOINTS), "it is the tool's, not the joints'"


def test_locked_axis_refers_to_the_frame_of_the_command() -> None:
    arm, servo = led(asked("panda"), ServoOptions(period=PERIOD, locked=(Axis.Z,)))
    turned = tool(arm, servo).rotation
    velocities = lead(arm, servo, Twist((0.1, 0.0, 0.2), frame=servo.frame), 0.5)
    assert velocities[-1] == pytest.approx(0.1 * turned[:, 0], abs=3e-3)


def test_pose_command_respects_locked_axes() -> None:
    arm, servo = led(asked("panda"), ServoOptions(period=PERIOD, locked=(Axis.Z, *tuple(Axis)[3:])))
    begin = tool(arm, servo)
    goal = to.placement(begin.translation + np.array((0.0, 0.08, 0.08)), rpy=(3.0, 0.3, 0.0))
    lead(arm, servo, Pose(goal), 1.5)
    moved = tool(arm, servo).translation - begin.translation
    assert moved == pytest.approx((0.0, 0.08, 0.0), abs=4e-3)
    assert tool(arm, servo).rotation == pytest.approx(begin.rotation, abs=2e-2)


@pytest.mark.parametrize("command", [Twist((0.0, 0.2, 0.0)), JointVelocities({"panda_joint1": 0.4})])
def test_low_pass_filter_is_of_first_order(command: Twist | JointVelocities) -> None:
    arm, servo = led(asked("panda"), ServoOptions(period=PERIOD, smoothing=0.1))
    lead(arm, servo, command, 0.2)
    asked_for = values_of(command, servo.problem.reduced, servo.options)
    assert servo._filtered == pytest.approx((1.0 - exp(-0.2 / 0.1)) * asked_for, rel=1e-9)


def test_filter_is_reset_for_other_axes_and_after_a_pause() -> None:
    arm, servo = led(asked("panda"), ServoOptions(period=PERIOD, smoothing=0.1))
    lead(arm, servo, Twist((0.0, 0.2, 0.0)), 0.3)
    servo.command(Twist((0.0, 0.1, 0.0), frame=servo.frame))
    assert not servo._filtered.any()
    lead(arm, servo, Twist((0.0, 0.2, 0.0)), 0.3)
    servo.release("let go")
    servo.command(Twist((0.0, 0.2, 0.0)))
    assert not servo._filtered.any()


@pytest.mark.parametrize("timeout", [0.03, 0.2])
def test_command_is_followed_until_its_timeout(timeout: float) -> None:
    arm, servo = led(asked("panda"), ServoOptions(period=PERIOD, timeout=timeout))
    lead(arm, servo, Twist((0.0, 0.2, 0.0)), 0.4)
    said = arm.now() - PERIOD
    while not kinds(servo):
        servo.tick()
        arm.advance(PERIOD)
    assert timeout < servo.events[0].time - said < timeout + 1.5 * PERIOD


def test_late_command_times_out_by_its_stamp() -> None:
    arm, servo = led(asked("panda"), ServoOptions(period=PERIOD, timeout=0.1))
    arm.advance(1.0)
    servo.command(Twist((0.0, 0.2, 0.0)), stamp=arm.now() - 0.2)
    servo.tick()
    assert kinds(servo) == [EventKind.STOPPING] and not servo.moving


@pytest.mark.parametrize(
    "command",
    [
        Twist((0.0, 0.2, 0.0)),
        JointVelocities({"panda_joint1": 0.4}),
        Pose(to.placement((0.5, 0.6, 0.5), rpy=(np.pi, 0, -0.4))),
    ],
)
def test_speed_factor_applies_to_all_commands(command: Twist | JointVelocities | Pose) -> None:
    reached: list[float] = []
    for speed in (1.0, 0.4, 0.0):
        arm, servo = led(asked("panda"))
        servo.slow_to(speed)
        velocities = lead(arm, servo, command, 0.7)
        reached.append(float(np.linalg.norm(velocities[-1])))
    assert reached[0] > 0.1
    assert reached[1] == pytest.approx(0.4 * reached[0], rel=0.1)
    assert reached[2] < 1e-6


@pytest.mark.parametrize("name", ["dead_zone", "smoothing", "turning", "scaling", "timeout"])
def test_invalid_options_are_refused(name: str) -> None:
    with pytest.raises(ProblemError, match=name):
        ServoOptions(**{name: -1.0})
