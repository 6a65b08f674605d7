"""An arm of Franka: a stand-in with franky's own types, and franky-sim over the protocol of Franka."""

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from tests.driving.streamed import Clock
from trajopt.driving import FrankaController, StreamingExecutor, conformance
from trajopt.values.errors import ExecutionError, MissingExtra, ProblemError, ShapeError
from trajopt.values.trajectory import Trajectory

JOINTS = tuple(f"panda_joint{i}" for i in range(1, 8))
READY = np.array((0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785))
PERIOD = 0.005


@pytest.fixture
def franky() -> Any:
    return pytest.importorskip("franky", reason="franky is not installed")


class Arm:
    """`franky.Robot`: the arm is at the reference of its motion, and stops without delay."""

    def __init__(self, franky: Any) -> None:
        self.franky, self.here, self.motion = franky, READY, None
        self.has_errors = self.stuck = False
        self.exception: Exception | None = None

    @property
    def current_joint_state(self) -> Any:
        if self.motion is None:
            return self.franky.JointState(self.here)
        reference = self.motion.get_reference()
        self.here = np.array(reference.q)
        return self.franky.JointState(reference.q, reference.dq)

    @property
    def is_in_control(self) -> bool:
        return self.motion is not None and self.exception is None

    def move(self, motion: Any, asynchronous: bool = False) -> None:
        assert asynchronous
        stops = isinstance(motion, self.franky.TorqueStopMotion)
        _ = self.current_joint_state
        self.motion = None if stops else motion

    def poll_motion(self) -> bool:
        return self.join_motion()

    def join_motion(self, timeout: float | None = None) -> bool:
        found, self.exception = self.exception, None
        if found is not None:
            self.motion = None
            raise found
        return self.motion is None

    def recover_from_errors(self) -> bool:
        self.has_errors = self.stuck
        return not self.stuck


def connected(franky: Any) -> tuple[Clock, Arm, StreamingExecutor]:
    clock, arm = Clock(), Arm(franky)
    executor = StreamingExecutor(FrankaController(arm), JOINTS, tolerance=1e-3, period=PERIOD, clock=clock)
    clock.drive(executor)
    return clock, arm, executor


def test_the_executor_conforms(franky: Any) -> None:
    clock, arm, executor = connected(franky)
    assert [str(rule) for rule in conformance(executor, clock.wait) if not rule.holds] == []
    np.testing.assert_array_equal(arm.motion.params.stiffness, (600, 600, 600, 600, 250, 150, 50))


def test_errors_of_the_arm_are_a_fault_until_they_are_cleared(franky: Any) -> None:
    clock, arm, executor = connected(franky)
    clock.wait(0.1)
    arm.has_errors = arm.stuck = True
    clock.wait(0.1)
    assert executor.fault() == "the arm reports errors"
    with pytest.raises(ExecutionError, match="does not recover"):
        executor.clear_fault()
    arm.stuck = False
    executor.clear_fault()
    clock.wait(0.1)
    assert executor.fault() == "" and arm.is_in_control


def test_the_exception_that_ended_the_control_is_the_fault(franky: Any) -> None:
    clock, arm, executor = connected(franky)
    clock.wait(0.1)
    arm.exception = franky.ControlException("joint_reflex")
    clock.wait(0.1)
    assert executor.fault() == "ControlException: joint_reflex"  # it is raised once, and stays
    executor.clear_fault()
    clock.wait(0.1)
    assert executor.fault() == "" and arm.is_in_control


@pytest.mark.parametrize(
    ("wrong", "kind"), [(np.zeros(7), ProblemError), (np.ones(6), ShapeError)], ids=["zero", "six"]
)
def test_a_wrong_stiffness_is_refused(franky: Any, wrong: np.ndarray, kind: type[Exception]) -> None:
    with pytest.raises(kind, match="stiffness"):
        FrankaController(Arm(franky), stiffness=wrong)


def test_nobody_at_the_address_is_refused(franky: Any) -> None:
    with pytest.raises(ExecutionError, match=r"cannot connect to the arm at 127\.9\.9\.8"):
        FrankaController.connect("127.9.9.8", realtime=False)


def test_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "franky", None)
    with pytest.raises(MissingExtra, match=r"trajopt-planner\[franka\]"):
        FrankaController.connect("10.0.0.2")


SIMULATION = """
import sys
from franky_sim import SimulationServer
from franky_sim.mujoco_simulator import MujocoSimulator
with MujocoSimulator(enable_visualization=False) as simulator:
    robot = simulator.add_robot()
    with SimulationServer(simulator) as server:
        server.run_async()
        print("address", robot.hostname, flush=True)
        sys.stdin.readline()
"""


@pytest.fixture
def host(franky: Any) -> Iterator[str]:
    """Run Franka's control interface on an arm in MuJoCo, in a process of its own."""
    pytest.importorskip("franky_sim", reason="franky-sim is not installed")
    command = (sys.executable, "-c", SIMULATION)
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdin is not None and child.stdout is not None
        yield next(line.split()[1] for line in child.stdout if line.startswith("address"))
        child.communicate("\n", timeout=60.0)


def driven(arm: FrankaController) -> StreamingExecutor:
    # Tests beside this one may make its thread and the simulation late.
    return StreamingExecutor(arm, JOINTS, tolerance=0.1, period=PERIOD, silence=5.0)


def until(reached: Callable[[], object]) -> None:
    deadline = time.monotonic() + 30.0
    while not reached() and time.monotonic() < deadline:
        time.sleep(0.01)
    assert reached()


@pytest.mark.slow
def test_a_motion_and_a_stop_over_the_wire(host: str) -> None:
    arm = FrankaController.connect(host, realtime=False)
    with driven(arm) as executor:
        for side in (1.0, -1.0):  # the second after a stop
            here = executor.committed(executor.now())[0]
            rows, still = np.stack((here, here + 0.1 * side)), np.zeros((2, 7))
            swing = Trajectory(JOINTS, np.array((0.0, 2.0)), rows, still, still)
            assert executor.splice(swing, executor.now() + 0.5) == ""
            until(lambda goal=rows[1]: np.abs(arm.measured()[0] - goal).max() < 0.03)
            assert executor.fault() == ""
            executor.stop()
            assert executor.fault() == "the driver stopped the robot"
            until(lambda: arm.error() == "the arm is not under control")
            executor.clear_fault()
            assert executor.fault() == ""
