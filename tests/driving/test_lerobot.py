"""A LeRobot robot behind a guard, over a stand-in of the interface."""

import math
from typing import Any

import numpy as np
import pytest

import trajopt as to
from tests.driving.streamed import Clock, Servos
from tests.driving.test_guard import touching
from trajopt.driving import (
    ActionOutcome,
    Guard,
    GuardedArm,
    LeRobotController,
    MotorJoint,
    StreamingExecutor,
    conformance,
)
from trajopt.values.errors import NameNotFound, ProblemError

GROUP, FPS = "panda_arm", 30.0
FRAME = 0.034
"""Time between actions [s], a little later than promised."""
WALL = to.Box(0.3, 0.02, 0.4), to.placement((0.31, -0.25, 0.6), rpy=(0.0, 0.0, -0.7))


class Arm:
    """Seven motors in degrees, one reversed and one with an offset, and a gripper in percent."""

    def __init__(self, clock: Clock, robot: to.Robot) -> None:
        joints = robot.group(GROUP).joints
        self.motors = {f"motor{number}.pos": MotorJoint(name) for number, name in enumerate(joints)}
        self.motors["motor1.pos"] = MotorJoint(joints[1], scale=-math.pi / 180.0)
        self.motors["motor2.pos"] = MotorJoint(joints[2], offset=0.3)
        self.servos = Servos(robot.positions("ready")[robot.index(joints)], clock, 0.02)
        self.gripper = 20.0

    @property
    def action_features(self) -> dict[str, type]:
        return dict.fromkeys((*self.motors, "gripper.pos"), float)

    def get_observation(self) -> dict[str, Any]:
        rows = zip(self.motors.items(), self.servos.positions(), strict=True)
        found = {name: float((at - motor.offset) / motor.scale) for (name, motor), at in rows}
        return {**found, "gripper.pos": self.gripper, "camera": np.zeros((2, 2, 3))}

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        rows = [motor.scale * action[name] + motor.offset for name, motor in self.motors.items()]
        self.servos.go(np.array(rows))
        self.gripper = action["gripper.pos"]
        return action


@pytest.fixture(scope="module")
def panda() -> to.Robot:
    return to.load("panda")


def connected(panda: to.Robot) -> tuple[Clock, Arm, LeRobotController, StreamingExecutor]:
    clock = Clock()
    arm = Arm(clock, panda)
    controller = LeRobotController(arm, arm.motors, clock=clock)
    executor = StreamingExecutor(controller, controller.joint_names, tolerance=1e-3, period=0.02, clock=clock)
    clock.drive(executor)
    return clock, arm, controller, executor


def test_the_executor_conforms(panda: to.Robot) -> None:
    clock, _, _, executor = connected(panda)
    assert [str(rule) for rule in conformance(executor, clock.wait) if not rule.holds] == []


def test_smooth_actions_are_sent_as_they_are(panda: to.Robot) -> None:
    clock, arm, controller, executor = connected(panda)
    guarded = GuardedArm(controller, Guard(to.Scene(panda), GROUP, executor), fps=FPS)
    begin = guarded.observe()
    for count in range(60):
        action = {name: begin[name] for name in arm.motors}
        action["motor0.pos"] += 20.0 * math.sin(0.03 * count) ** 2
        sent = guarded.send({**action, "gripper.pos": float(count)})
        assert guarded.decision is not None and guarded.decision.outcome is ActionOutcome.AS_GIVEN
        assert sent["gripper.pos"] == count
        for name, value in action.items():
            assert sent[name] == pytest.approx(value, abs=0.05)
        clock.wait(FRAME)
    assert arm.gripper == 59.0
    clock.wait(0.5)
    assert guarded.observe()["motor0.pos"] == pytest.approx(action["motor0.pos"], abs=0.1)
    assert guarded.observe()["camera"].shape == (2, 2, 3)


@pytest.mark.parametrize(("fps", "late"), [(5.0, 1.4), (10.0, 1.0), (15.0, 1.2), (30.0, 1.4)])
def test_slow_and_late_policies_are_followed(panda: to.Robot, fps: float, late: float) -> None:
    clock, arm, controller, executor = connected(panda)
    guarded = GuardedArm(controller, Guard(to.Scene(panda), GROUP, executor), fps=fps)
    begin, first = guarded.observe(), clock.time

    def wanted(time: float) -> float:
        return 6.0 * math.sin(1.9 * time) * (1.0 - math.exp(-(time**3)))

    while clock.time < first + 5.0:
        at = wanted(clock.time - first + 0.05 + 1.0 / fps)
        guarded.send({**{name: begin[name] + at for name in arm.motors}, "gripper.pos": 0.0})
        for _ in range(5):
            clock.wait(late / fps / 5.0)
            off = arm.get_observation()["motor0.pos"] - begin["motor0.pos"] - wanted(clock.time - first)
            assert abs(off) < 2.0


def test_actions_through_a_wall_stop_before_it(panda: to.Robot) -> None:
    scene = to.Scene(panda).add("wall", *WALL)
    clock, arm, controller, executor = connected(panda)
    guarded = GuardedArm(controller, Guard(scene, GROUP, executor), fps=FPS)
    begin, rows = guarded.observe(), list[np.ndarray]()
    wanted = list[np.ndarray]()
    for count in range(90):
        action = {name: begin[name] for name in arm.motors}
        action["motor0.pos"] -= min(count, 60)
        sent = guarded.send(action)
        wanted.append(controller.positions(action))
        for _ in range(17):
            clock.wait(FRAME / 17.0)
            rows.append(arm.servos.positions())
    assert touching(scene, np.array(wanted)[:, None])
    assert not touching(scene, np.array(rows)[:, None])
    assert guarded.decision is not None and guarded.decision.outcome is not ActionOutcome.AS_GIVEN
    assert sent["motor0.pos"] > action["motor0.pos"] + 10.0
    np.testing.assert_allclose(rows[-1], controller.positions(sent), atol=1e-3)


def test_a_silent_policy_ends_at_rest_on_its_proven_stop(panda: to.Robot) -> None:
    clock, arm, controller, executor = connected(panda)
    guarded = GuardedArm(controller, Guard(to.Scene(panda), GROUP, executor), fps=FPS)
    begin = guarded.observe()
    for count in range(15):
        guarded.send(
            {**{name: begin[name] for name in arm.motors}, "motor0.pos": begin["motor0.pos"] + count}
        )
        clock.wait(FRAME)
    assert np.abs(executor.committed(clock.time)[1]).max() > 0.3
    clock.wait(2.0)
    assert not executor.committed(clock.time)[1].any() and not executor.state().velocities.any()
    np.testing.assert_allclose(arm.servos.positions(), executor.committed(clock.time)[0])


@pytest.mark.parametrize("wrong", [math.nan, None, "left", [1.0]])
def test_actions_that_are_not_numbers_stop_the_robot(panda: to.Robot, wrong: object) -> None:
    clock, arm, controller, executor = connected(panda)
    guarded = GuardedArm(controller, Guard(to.Scene(panda), GROUP, executor), fps=FPS)
    begin = guarded.observe()
    sent = guarded.send(dict.fromkeys(arm.motors, wrong))
    assert guarded.decision is not None and guarded.decision.outcome is ActionOutcome.STOPPED
    assert sent == pytest.approx({name: begin[name] for name in arm.action_features})
    clock.wait(0.5)
    assert guarded.observe()["motor3.pos"] == pytest.approx(begin["motor3.pos"])


def test_a_new_guard_resumes_after_a_fault(panda: to.Robot) -> None:
    clock, arm, controller, executor = connected(panda)
    scene = to.Scene(panda)
    guarded = GuardedArm(controller, Guard(scene, GROUP, executor), fps=FPS)
    begin = guarded.observe()
    still = {name: begin[name] for name in arm.motors}
    executor.stop()
    clock.wait(0.1)
    guarded.send(still)
    assert guarded.decision is not None and guarded.decision.outcome is ActionOutcome.STOPPED
    assert "does not follow" in guarded.decision.reason
    executor.clear_fault()
    again = GuardedArm(controller, Guard(scene, GROUP, executor), fps=FPS)
    for _ in range(20):
        again.send({**still, "motor0.pos": still["motor0.pos"] + 0.1})
        assert again.decision is not None and again.decision.outcome is ActionOutcome.AS_GIVEN
        clock.wait(FRAME)
    assert again.observe()["motor0.pos"] == pytest.approx(still["motor0.pos"] + 0.1, abs=0.01)


def test_missing_features_and_joints_are_named(panda: to.Robot) -> None:
    clock, arm, controller, executor = connected(panda)
    with pytest.raises(NameNotFound, match=r"motr0.pos.*motor0.pos"):
        LeRobotController(arm, {"motr0.pos": MotorJoint("panda_joint1")}, clock=clock)
    with pytest.raises(ProblemError, match="several drive joint 'panda_joint1'"):
        LeRobotController(arm, {**arm.motors, "gripper.pos": MotorJoint("panda_joint1")}, clock=clock)
    guarded = GuardedArm(controller, Guard(to.Scene(panda), GROUP, executor), fps=FPS)
    with pytest.raises(NameNotFound, match=r"motor0\.pos"):
        guarded.send({"gripper.pos": 1.0})
    some = LeRobotController(arm, dict(list(arm.motors.items())[:6]), clock=clock)
    with pytest.raises(ProblemError, match="panda_joint7"):
        GuardedArm(some, guarded.guard, fps=FPS)
    with pytest.raises(ProblemError, match="scale must not be 0"):
        MotorJoint("panda_joint1", scale=0.0)
