"""The executors of trajopt conform, and violations are found."""

import re

import numpy as np
import pytest

import trajopt as to
from trajopt.driving import IdealExecutor, RobotState, Sensors, SimulatedExecutor, conformance
from trajopt.values.errors import ProblemError


@pytest.fixture(scope="module")
def panda() -> to.Robot:
    try:
        return to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))


def test_the_ideal_executor_conforms(panda: to.Robot) -> None:
    arm = IdealExecutor(panda.joint_names, panda.positions("ready"))
    assert [str(rule) for rule in conformance(arm, arm.advance) if not rule.holds] == []


def test_the_simulated_executor_conforms(panda: to.Robot) -> None:
    arm = SimulatedExecutor(to.Scene(panda), panda.positions("ready"), tolerance=5e-3)
    broken = [str(rule) for rule in conformance(arm, arm.advance, step=0.01) if not rule.holds]
    assert broken == []


class Careless(IdealExecutor):
    """Takes whatever comes, and does not stop."""

    def splice(self, trajectory: to.Trajectory, at: float) -> str:
        self.committed.splice(trajectory, max(at, self.now()), now=self.now())
        return ""

    def stop(self) -> None:
        pass


def test_executor_that_accepts_everything_does_not_conform(panda: to.Robot) -> None:
    arm = Careless(panda.joint_names, panda.positions("ready"))
    broken = {rule.name for rule in conformance(arm, arm.advance) if not rule.holds}
    assert {
        "it refuses a late motion",
        "it refuses a motion from another position",
        "it refuses a motion that does not end at rest",
        "a refused motion changes nothing",
        "a stop is a fault",
        "it accepts no motion during a fault",
    } <= broken


class Sluggish(IdealExecutor):
    """Is always where it should have been a while ago."""

    def state(self) -> RobotState:
        now = self.now()
        here = self.committed(now - 0.1)
        return RobotState(now, *here, self.committed(now)[0])


def test_executor_with_a_lag_does_not_conform(panda: to.Robot) -> None:
    arm = Sluggish(panda.joint_names, panda.positions("ready"))
    broken = [rule for rule in conformance(arm, arm.advance) if not rule.holds]
    assert any("follows within its tolerance" in rule.name for rule in broken)


def test_sensors_have_the_requested_delay_and_noise(panda: to.Robot) -> None:
    scene, ready = to.Scene(panda), panda.positions("ready")
    arm = SimulatedExecutor(scene, ready, sensors=Sensors(delay=0.02, noise=1e-3, seed=3))
    arm.advance(0.5)
    assert arm.now() - arm.state().stamp == pytest.approx(0.02)
    measured = []
    for _ in range(200):
        arm.advance(0.02)
        measured.append(arm.state().positions)
    assert np.std(measured, axis=0) == pytest.approx(1e-3, rel=0.25)


AT_SPEED = "it follows at full speed within its tolerance"


class Ticking(IdealExecutor):
    """Sends where the joints have to be every 4 ms, and measures what it sent last."""

    stamped_by_tick = True

    def state(self) -> RobotState:
        now = self.now()
        ticked = np.floor(now / 0.004 + 1e-9) * 0.004
        positions, velocities, accelerations = self.committed(ticked)
        stamp = ticked if self.stamped_by_tick else now
        return RobotState(stamp, positions, velocities, accelerations, self.committed(stamp)[0])


class StampedByNow(Ticking):
    """Stamps what it sent last by the time now."""

    stamped_by_tick = False


def at_speed(panda: to.Robot, kind: type[Ticking], tolerance: float, speed: float = 1.0) -> str:
    arm = kind(panda.joint_names, panda.positions("ready"))
    arm.tolerance[:] = tolerance
    rules = {rule.name: rule.broken for rule in conformance(arm, arm.advance, step=0.01, speed=speed)}
    assert [name for name, broken in rules.items() if broken and name != AT_SPEED] == []
    return rules[AT_SPEED]


def test_states_stamped_by_the_tick_hold_at_any_speed(panda: to.Robot) -> None:
    assert at_speed(panda, Ticking, 1e-3, speed=3.0) == ""


def test_states_stamped_by_now_need_a_tolerance_of_speed_times_period(panda: to.Robot) -> None:
    broken = at_speed(panda, StampedByNow, 1e-3)
    found = re.search(r"states are up to (\d\.\d) ms behind their stamps: at 1 rad/s", broken)
    assert found is not None and 3.0 < float(found[1]) < 5.0
    assert "or state a tolerance of at least 0.00" in broken
    assert at_speed(panda, StampedByNow, 1e-3, speed=0.2) == ""
    assert at_speed(panda, StampedByNow, 6e-3) == ""


def test_noise_within_the_tolerance_does_not_count_as_delay(panda: to.Robot) -> None:
    for seed in range(3):
        sensors = Sensors(noise=1e-3, seed=seed)
        arm = SimulatedExecutor(to.Scene(panda), panda.positions("ready"), sensors=sensors)
        rules = conformance(arm, arm.advance, step=0.01)
        assert [str(rule) for rule in rules if rule.name == AT_SPEED and not rule.holds] == []


@pytest.mark.parametrize("wrong", [{"step": 0.0}, {"duration": -1.0}, {"speed": 0.0}])
def test_numbers_that_are_not_positive_are_refused(panda: to.Robot, wrong: dict[str, float]) -> None:
    arm = IdealExecutor(panda.joint_names, panda.positions("ready"))
    with pytest.raises(ProblemError, match=f"{next(iter(wrong))} must be positive"):
        conformance(arm, arm.advance, **wrong)


def test_missing_members_are_named_and_no_others(panda: to.Robot) -> None:
    class Unfinished:
        joint_names, period, latency = panda.joint_names, 0.004, 0.01
        tolerance = np.full(len(panda.joint_names), 1e-3)

        def now(self) -> float:
            return 0.0

        def fault(self) -> str:
            return ""

    with pytest.raises(ProblemError) as refused:
        conformance(Unfinished(), lambda seconds: None)  # pyright: ignore
    assert str(refused.value).startswith("executor must be an Executor, is ")
    assert str(refused.value).endswith("; it lacks clear_fault, splice, state, stop")
