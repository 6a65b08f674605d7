"""The package ur_rtde drives a stand-in of the controller over TCP, in real time."""

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from tests.driving.rtde_controller import StandIn
from trajopt.driving import StreamingExecutor, Supervisor, UrController, conformance
from trajopt.values.errors import ExecutionError

pytest.importorskip("rtde_control", reason="ur_rtde is not installed")
pytestmark = pytest.mark.slow
PERIOD = 0.008


@pytest.fixture
def controller() -> Iterator[StandIn]:
    with StandIn() as found:
        yield found


def connected(controller: StandIn) -> UrController:
    return UrController.connect(controller.host, period=PERIOD, lookahead=0.05, gain=300.0)


def driven(arm: UrController, joints: tuple[str, ...]) -> StreamingExecutor:
    return StreamingExecutor(arm, joints, tolerance=0.02, period=PERIOD, lag=0.005, silence=5.0)


def until(reached: Callable[[], object]) -> None:
    deadline = time.monotonic() + 30.0
    while not reached() and time.monotonic() < deadline:
        time.sleep(0.01)
    assert reached()


def rests_at(arm: UrController, goal: np.ndarray) -> bool:
    positions, velocities = arm.measured()
    return np.abs(positions - goal).max() < 1e-9 and not velocities.any()


def test_a_position_arrives_over_the_wire(controller: StandIn) -> None:
    arm = connected(controller)
    assert b"servoj(q, t=dt, lookahead_time=lh_time, gain=g)" in controller.read("script")
    goal = np.array((0.1, -0.2, 0.3, -0.4, 0.5, -0.6))
    arm.command(goal, np.zeros(6))
    until(lambda: rests_at(arm, goal))
    assert controller.read("timing") == [0.0, 0.0, PERIOD, 0.05, 300.0] and arm.error() == ""
    arm.brake()
    assert controller.read("stops") == [10.0]
    arm.command(np.zeros(6), np.zeros(6))
    until(lambda: rests_at(arm, np.zeros(6)))
    arm.close()


def test_the_executor_conforms_in_real_time(controller: StandIn) -> None:
    arm = connected(controller)
    with driven(arm, tuple(f"joint{i}" for i in range(6))) as executor:
        assert [str(rule) for rule in conformance(executor, time.sleep, speed=0.2) if not rule.holds] == []
    arm.close()


def test_a_supervisor_drives_it(controller: StandIn) -> None:
    problem = replace(to.named_problem("past_pillar_ur5"), velocity_scaling=0.1)  # a thread is late at times
    names, start = problem.reduced.joint_names, problem.reduced.start_positions
    controller.set("target", start.tolist())
    arm = connected(controller)
    until(lambda: rests_at(arm, start))
    with driven(arm, names) as executor:
        supervisor = Supervisor(executor, problem)
        supervisor.go(problem)
        deadline = time.monotonic() + 60.0
        while supervisor.busy and time.monotonic() < deadline:
            supervisor.cycle()
            time.sleep(0.02)
        assert not supervisor.busy and executor.fault() == "", supervisor.events
        there = executor.committed(executor.now())[0]
    assert np.abs(there - start).max() > 0.1
    np.testing.assert_allclose(controller.read("q"), there, atol=1e-6)
    arm.close()


@pytest.mark.parametrize(
    ("name", "words"), [("protective", "protective stop"), ("emergency", "emergency stop")]
)
def test_a_stop_is_a_fault_until_it_is_cleared_on_the_pendant(
    controller: StandIn, name: str, words: str
) -> None:
    arm = connected(controller)
    controller.set(name, True)
    until(lambda: words in arm.error())
    with pytest.raises(ExecutionError, match=words):
        arm.command(np.ones(6), np.zeros(6))
    with pytest.raises(ExecutionError, match=words):
        arm.reset()
    assert not controller.read("servoed")
    controller.set(name, False)
    until(lambda: arm.error() == "the control script does not run on the arm")
    arm.reset()
    until(lambda: arm.error() == "")
    arm.command(np.full(6, 0.01), np.zeros(6))
    until(lambda: controller.read("servoed") == 1)
    arm.close()


LOST = """
import sys, numpy as np
from trajopt.driving import UrController
arm = UrController.connect(sys.argv[1], period=0.008)
print("connected", flush=True)
sys.stdin.readline()
while not arm.error():
    pass
print("error:", arm.error(), flush=True)
arm.brake()
try:
    arm.command(np.zeros(6), np.zeros(6))
except Exception as error:
    print(type(error).__name__, error, flush=True)
"""


def test_a_lost_controller_is_a_fault(controller: StandIn) -> None:
    # In a process of its own, since ur_rtde ends the process if its own thread fails.
    command = (sys.executable, "-c", LOST, controller.host)
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdin is not None and child.stdout is not None
        assert child.stdout.readline() == "connected\n"
        controller.end()
        printed = child.communicate("\n", timeout=60.0)[0]
    assert "error: the connection to the arm is lost\n" in printed
    assert "ExecutionError the arm does not take servoJ: the connection to the arm is lost\n" in printed


def test_nobody_at_the_address_is_refused() -> None:
    with pytest.raises(ExecutionError, match=r"cannot connect to the arm at 127\.9\.9\.9"):
        UrController.connect("127.9.9.9")
