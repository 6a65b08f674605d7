"""The executors that come with trajopt do what they must, and one that does not is found out."""

import numpy as np
import pytest

import trajopt as to
from trajopt.driving import IdealExecutor, Sensors, SimulatedExecutor, conformance


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


def test_who_takes_everything_is_found_out(panda: to.Robot) -> None:
    arm = Careless(panda.joint_names, panda.positions("ready"))
    broken = {rule.name for rule in conformance(arm, arm.advance) if not rule.holds}
    assert {
        "it refuses a motion that comes late",
        "it refuses a motion that begins elsewhere",
        "it refuses a motion that does not end at rest",
        "what is refused changes nothing",
        "a stop is a fault",
        "it takes nothing while there is a fault",
    } <= broken


class Sluggish(IdealExecutor):
    """Is always where it should have been a while ago."""

    def state(self) -> to.driving.RobotState:
        now = self.now()
        here = self.committed(now - 0.1)
        return to.driving.RobotState(now, *here, self.committed(now)[0])


def test_who_lags_is_found_out(panda: to.Robot) -> None:
    arm = Sluggish(panda.joint_names, panda.positions("ready"))
    broken = [rule for rule in conformance(arm, arm.advance) if not rule.holds]
    assert any("follows within its tolerance" in rule.name for rule in broken)


def test_sensors_are_late_and_noisy_as_asked(panda: to.Robot) -> None:
    scene, ready = to.Scene(panda), panda.positions("ready")
    arm = SimulatedExecutor(scene, ready, sensors=Sensors(delay=0.02, noise=1e-3, seed=3))
    arm.advance(0.5)
    assert arm.now() - arm.state().stamp == pytest.approx(0.02)
    measured = []
    for _ in range(200):
        arm.advance(0.02)
        measured.append(arm.state().positions)
    assert np.std(measured, axis=0) == pytest.approx(1e-3, rel=0.25)
