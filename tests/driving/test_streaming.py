"""An executor that sends a position in each period, over a stand-in of a controller."""

import time
from collections.abc import Callable

import numpy as np
import pytest

import trajopt as to
from tests.driving.streamed import Clock, Servos
from trajopt.driving import StreamingExecutor, conformance
from trajopt.values.arrays import Floats
from trajopt.values.errors import ProblemError

JOINTS = ("shoulder", "elbow")


class Controller:
    def __init__(self, clock: Callable[[], float], period: float = 0.01) -> None:
        self.servos, self.failure, self.broken = Servos(np.zeros(2), clock, period), "", False
        self.commands = list[Floats]()

    def measured(self) -> tuple[Floats, Floats]:
        return self.servos.positions(), self.servos.velocities()

    def command(self, positions: Floats, velocities: Floats) -> None:
        if self.broken:
            raise ConnectionError("cable")
        self.commands.append(positions)
        self.servos.go(positions)

    def brake(self) -> None:
        self.servos.go(self.servos.positions())

    def error(self) -> str:
        return self.failure

    def reset(self) -> None:
        self.failure = ""


def executor(clock: Clock, controller: Controller, *, lag: float = 0.0) -> StreamingExecutor:
    arm = StreamingExecutor(
        controller, JOINTS, tolerance=1e-6, period=0.01, lag=lag, silence=0.5, clock=clock
    )
    clock.drive(arm)
    return arm


def swing(size: float = 0.1) -> to.Trajectory:
    still = np.zeros((2, 2))
    rows = np.array(((0.0, 0.0), (size, -size)))
    return to.Trajectory(JOINTS, np.array((0.0, 1.0)), rows, still, still)


def test_it_conforms() -> None:
    clock = Clock()
    arm = executor(clock, Controller(clock))
    assert [str(rule) for rule in conformance(arm, clock.wait) if not rule.holds] == []


def test_a_wrong_lag_does_not_conform() -> None:
    clock = Clock()
    arm = executor(clock, Controller(clock), lag=0.03)
    broken = [str(rule) for rule in conformance(arm, clock.wait) if not rule.holds]
    assert any("follows" in rule for rule in broken)


def test_commands_are_the_committed_positions() -> None:
    clock = Clock()
    arm = executor(clock, controller := Controller(clock))
    begin = clock.time + 0.1
    assert arm.splice(swing(), begin) == ""
    for _ in range(120):
        clock.wait(0.01)
        np.testing.assert_array_equal(controller.commands[-1], arm.committed(clock.time)[0])
    np.testing.assert_allclose(controller.servos.positions(), (0.1, -0.1))


def test_an_error_of_the_connection_is_a_fault_that_can_be_cleared() -> None:
    clock = Clock()
    arm = executor(clock, controller := Controller(clock))
    controller.broken = True
    clock.wait(0.02)
    assert arm.fault() == "ConnectionError: cable"
    assert arm.splice(swing(), clock.time + 0.1) == arm.fault()
    controller.broken = False
    arm.clear_fault()
    assert arm.fault() == "" and arm.splice(swing(), clock.time + 0.1) == ""


def test_a_controller_with_an_error_gets_no_commands() -> None:
    clock = Clock()
    arm = executor(clock, controller := Controller(clock))
    clock.wait(0.05)
    controller.failure, sent = "protective stop", len(controller.commands)
    clock.wait(0.05)
    assert arm.fault() == "protective stop" and len(controller.commands) == sent


def test_a_loop_that_ended_is_a_fault() -> None:
    clock = Clock()
    arm = executor(clock, Controller(clock))
    clock.tick = lambda: None
    clock.wait(0.4)
    assert arm.fault() == ""
    clock.wait(0.2)
    assert arm.fault() == "the loop of the driver has not run for 0.60 s"


def test_a_motion_does_not_jump_after_a_loop_that_stood_still() -> None:
    clock = Clock()
    arm = executor(clock, controller := Controller(clock))
    assert arm.splice(swing(), clock.time + 0.1) == ""
    clock.wait(0.5)
    tick, clock.tick = clock.tick, lambda: None
    clock.wait(0.6)
    last, clock.tick = controller.commands[-1], tick
    clock.wait(0.1)
    assert np.abs(np.diff(controller.commands, axis=0)).max() < 3e-3
    np.testing.assert_array_equal(controller.commands[-1], last)
    assert arm.fault().startswith("the loop of the driver has not run for 0.6")
    arm.clear_fault()
    clock.wait(0.1)
    np.testing.assert_allclose(controller.commands[-1], last, atol=1e-9)


def test_at_rest_a_loop_may_stand_still() -> None:
    clock = Clock()
    arm = executor(clock, Controller(clock))
    tick, clock.tick = clock.tick, lambda: None
    clock.wait(0.6)
    clock.tick = tick
    clock.wait(0.02)
    assert arm.fault() == ""


def test_a_thread_ticks_within_a_block_and_stops_the_robot_after_it() -> None:
    controller = Controller(time.monotonic)
    arm = StreamingExecutor(controller, JOINTS, tolerance=0.1, period=0.01)
    with arm:
        assert arm.splice(swing(0.01), arm.now() + 0.4) == ""
        deadline = time.monotonic() + 20.0
        while controller.servos.positions()[0] < 0.01 - 1e-9 and time.monotonic() < deadline:
            time.sleep(0.01)
    np.testing.assert_allclose(controller.servos.goal, (0.01, -0.01), atol=1e-9)
    assert arm.fault()
    sent = len(controller.commands)
    time.sleep(0.05)
    assert len(controller.commands) == sent


@pytest.mark.parametrize(
    "wrong", [{"period": 0.0}, {"silence": -1.0}, {"lag": -0.1}, {"tolerance": -0.1}], ids=str
)
def test_numbers_out_of_range_are_refused(wrong: dict[str, float]) -> None:
    given = {"period": 0.01, "tolerance": 0.1, **wrong}
    with pytest.raises(ProblemError, match=next(iter(wrong))):
        StreamingExecutor(Controller(time.monotonic), JOINTS, **given)
