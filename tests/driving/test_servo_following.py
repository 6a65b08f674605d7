"""Tracking of a servo: as fast as limits allow, at full speed along obstacles, to a pose, to a limit."""

import numpy as np
import pytest

import trajopt as to
from tests.driving.test_servo import PERIOD, SPEED, TABLE, asked, kinds, lead, led, tool
from trajopt.driving import JointVelocities, Pose, Twist
from trajopt.driving.motion_guard import MotionGuard
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.optimise.methods.timing import with_jerk
from trajopt.verify import Judge, Verdict


@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_joint_reaches_its_velocity_as_fast_as_limits_allow(name: str) -> None:
    problem = asked(name)
    arm, servo = led(problem)
    limits, joint = with_jerk(problem.limits), problem.reduced.joint_names[0]
    speed, most, jerk = 0.6, float(limits.acceleration[0]), float(limits.jerk[0])
    soonest = speed / most + most / jerk if speed > most**2 / jerk else 2.0 * np.sqrt(speed / jerk)
    lead(arm, servo, JointVelocities({joint: speed}), soonest + arm.latency + 4.0 * PERIOD)
    assert arm.state().velocities[0] == pytest.approx(speed, rel=1e-3)
    lead(arm, servo, JointVelocities({}), soonest + arm.latency + 4.0 * PERIOD)
    assert np.abs(arm.state().velocities).max() < 1e-3
    assert not kinds(servo)


@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_a_twist_that_changes_slowly_is_followed_closely(name: str) -> None:
    arm, servo = led(asked(name))
    size, late = 0.05, arm.latency + 3.0 * PERIOD
    for number in range(200):
        phase = np.pi * number * PERIOD
        twist = size * np.array((0.0, np.sin(phase), np.cos(phase)))
        velocity = lead(arm, servo, Twist(twist), PERIOD)[0]
        if number > 30:  # it begins at rest, from which it takes a time
            assert np.linalg.norm(velocity - twist) < size * np.pi * late
    assert not kinds(servo)


@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_moves_along_a_table_at_full_speed(name: str) -> None:
    arm, servo = led(asked(name, TABLE))
    lead(arm, servo, Twist((0.0, 0.0, -SPEED)), 2.5)
    for pressed in (0.0, -0.1 * SPEED):
        along = lead(arm, servo, Twist((0.0, SPEED, pressed)), 0.6)
        assert along[-1, 1] == pytest.approx(SPEED, rel=0.02)
        back = lead(arm, servo, Twist((0.0, -SPEED, pressed)), 0.6)
        assert back[-1, 1] == pytest.approx(-SPEED, rel=0.02)
    assert Judge(servo.problem.reduced).examine(arm.state().positions).clear
    assert not kinds(servo)


@pytest.mark.parametrize(("name", "joint"), [("panda", "panda_joint1"), ("ur5", "wrist_3_joint")])
def test_joint_velocities_are_followed_up_to_the_limit_of_a_joint(name: str, joint: str) -> None:
    problem = asked(name)
    arm, servo = led(problem)
    column = problem.reduced.joint_names.index(joint)
    lead(arm, servo, JointVelocities({joint: 1.0}), 0.5)
    assert np.delete(arm.state().velocities, column) == pytest.approx(0.0, abs=1e-3)
    assert arm.state().velocities[column] == pytest.approx(1.0, abs=1e-3)
    lead(arm, servo, JointVelocities({joint: 9.0}), 3.5)
    assert arm.state().positions[column] <= problem.limits.upper[column]
    assert arm.state().positions[column] > problem.limits.upper[column] - 0.05
    assert np.abs(arm.state().velocities).max() < 0.1
    assert not kinds(servo)


@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_a_pose_is_reached_without_overshoot(name: str) -> None:
    arm, servo = led(asked(name))
    begin = tool(arm, servo)
    goal = to.placement(begin.translation + np.array((0.0, 0.1, 0.05)), rotation=begin.rotation)
    highest = 0.0
    for _ in range(40):
        lead(arm, servo, Pose(goal), 0.05)
        highest = max(highest, float((tool(arm, servo).translation - goal.translation)[1]))
    assert tool(arm, servo).translation == pytest.approx(goal.translation, abs=1e-3)
    assert highest < 1e-3


def test_rehearsal_proves_a_motion_without_moving(monkeypatch: pytest.MonkeyPatch) -> None:
    proven: list[bool] = []
    whole = MotionGuard.verdict

    def counted(guard: MotionGuard, motion: to.Trajectory, world: WorldSnapshot, begin: float) -> Verdict:
        found = whole(guard, motion, world, begin)
        proven.append(found.verified)
        return found

    monkeypatch.setattr(MotionGuard, "verdict", counted)
    arm, servo = led(asked("panda"))
    assert proven == [True], "so a first tick takes no longer than the others"
    assert not servo.moving and not servo.events and not arm.state().velocities.any()
    assert not servo._filtered.any()
