"""An arm of Universal Robots, over a stand-in of the two interfaces of ur_rtde."""

import sys
from importlib import import_module
from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import trajopt as to
from tests.driving.streamed import Clock, Servos
from trajopt.driving import StreamingExecutor, Supervisor, UrController, conformance
from trajopt.values.errors import ExecutionError, MissingExtra, ProblemError

JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
PERIOD = 0.008


class Arm:
    """Both interfaces: the arm reaches a position within the period of servoJ, and stops at once."""

    def __init__(self, clock: Clock, positions: np.ndarray) -> None:
        self.servos = Servos(positions, clock, PERIOD)
        self.protective = self.emergency = False
        self.connected = self.running = True
        self.stops = list[float]()

    def servoJ(  # its name in ur_rtde
        self, q: list[float], speed: float, acceleration: float, time: float, lookahead: float, gain: float, /
    ) -> bool:
        assert isinstance(q, list) and len(q) == 6 and (speed, acceleration) == (0.0, 0.0)
        assert (time, lookahead, gain) == (PERIOD, 0.05, 300.0)
        if self.protective or not self.running:
            return False
        self.servos.go(np.array(q))
        return True

    def servoStop(self, a: float = 10.0) -> bool:
        self.stops.append(a)
        self.servos.go(self.servos.positions())
        return True

    def isProgramRunning(self) -> bool:
        return self.running

    def reuploadScript(self) -> bool:
        self.running = not self.protective
        return self.running

    def stopScript(self) -> None:
        self.running = False

    def disconnect(self) -> None:
        self.connected = False

    def getActualQ(self) -> list[float]:
        return self.servos.positions().tolist()

    def getActualQd(self) -> list[float]:
        return self.servos.velocities().tolist()

    def isConnected(self) -> bool:
        return self.connected

    def isProtectiveStopped(self) -> bool:
        return self.protective

    def isEmergencyStopped(self) -> bool:
        return self.emergency


def connected(
    joints: tuple[str, ...] = JOINTS, positions: np.ndarray | None = None
) -> tuple[Clock, Arm, StreamingExecutor]:
    clock = Clock()
    arm = Arm(clock, np.zeros(6) if positions is None else positions)
    controller = UrController(arm, arm, period=PERIOD, lookahead=0.05, gain=300.0)
    executor = StreamingExecutor(controller, joints, tolerance=1e-3, period=PERIOD, clock=clock)
    clock.drive(executor)
    return clock, arm, executor


def test_the_executor_conforms() -> None:
    clock, arm, executor = connected()
    assert [str(rule) for rule in conformance(executor, clock.wait) if not rule.holds] == []
    assert arm.stops == [10.0]


def test_a_supervisor_drives_a_ur5() -> None:
    problem = to.named_problem("past_pillar_ur5")
    reduced = problem.reduced
    clock, arm, executor = connected(reduced.joint_names, reduced.start_positions)
    supervisor = Supervisor(executor, problem)
    supervisor.go(problem)
    for _ in range(2000):
        if not supervisor.busy:
            break
        supervisor.cycle()
        clock.wait(0.02)
    assert not supervisor.busy and not executor.fault()
    assert np.abs(arm.servos.positions() - reduced.start_positions).max() > 0.1
    np.testing.assert_allclose(arm.servos.positions(), executor.committed(clock.time)[0], atol=1e-6)


@pytest.mark.parametrize(
    ("state", "words"),
    [
        ({"protective": True}, "protective stop"),
        ({"emergency": True}, "emergency stop"),
        ({"connected": False}, "connection to the arm is lost"),
        ({"running": False}, "the control script does not run"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_stopped_arm_is_reported_as_a_fault(state: dict[str, bool], words: str) -> None:
    clock, arm, executor = connected()
    clock.wait(0.1)
    sent = arm.servos.sent
    for name, value in state.items():
        setattr(arm, name, value)
    clock.wait(0.1)
    assert words in executor.fault() and arm.servos.sent == sent
    if "running" in state:
        executor.clear_fault()
        assert executor.fault() == ""
        return
    with pytest.raises(ExecutionError, match=words):
        executor.clear_fault()


def test_a_refused_command_is_a_fault_with_its_reason() -> None:
    clock, arm, _ = connected()
    controller = UrController(arm, arm, period=PERIOD, lookahead=0.05, gain=300.0)
    arm.protective = True
    with pytest.raises(ExecutionError, match="does not take servoJ: the arm is in a protective stop"):
        controller.command(np.zeros(6), np.zeros(6))
    assert clock.time == 100.0


def test_the_script_ends_with_the_connection() -> None:
    arm = Arm(Clock(), np.zeros(6))
    controller = UrController(arm, arm, period=PERIOD)
    controller.close()
    assert not arm.running and not arm.connected
    controller.brake()
    assert arm.stops == [] and controller.error() == "the connection to the arm is lost"


@pytest.mark.parametrize(
    "wrong", [{"lookahead": 0.01}, {"gain": 3000.0}, {"period": 0.0}, {"deceleration": -1.0}], ids=str
)
def test_numbers_out_of_range_are_refused(wrong: dict[str, float]) -> None:
    arm = Arm(Clock(), np.zeros(6))
    with pytest.raises(ProblemError, match=next(iter(wrong))):
        UrController(arm, arm, **wrong)


def test_it_connects_with_ur_rtde(monkeypatch: pytest.MonkeyPatch) -> None:
    made = list[tuple[Any, ...]]()

    def interface(*given: Any) -> Arm:
        made.append(given)
        return Arm(Clock(), np.zeros(6))

    def refused(*given: Any) -> Arm:
        raise RuntimeError("no route to host")

    modules = {name: SimpleNamespace(**{kind: interface}) for name, kind in INTERFACES.items()}
    for name, module in modules.items():
        monkeypatch.setitem(sys.modules, name, module)
    controller = UrController.connect("10.0.0.2", period=0.008)
    assert made == [("10.0.0.2", 125.0), ("10.0.0.2", 125.0)] and controller.error() == ""
    modules["rtde_receive"].RTDEReceiveInterface = refused
    with pytest.raises(ExecutionError, match=r"10\.0\.0\.2: no route to host"):
        UrController.connect("10.0.0.2")
    monkeypatch.setitem(sys.modules, "rtde_control", None)
    with pytest.raises(MissingExtra, match=r"trajopt-planner\[ur\]"):
        UrController.connect("10.0.0.2")


INTERFACES = {"rtde_control": "RTDEControlInterface", "rtde_receive": "RTDEReceiveInterface"}


@pytest.mark.skipif(find_spec("rtde_control") is None, reason="ur_rtde is not installed")
def test_the_stand_in_has_the_methods_of_the_package() -> None:
    kinds = [getattr(import_module(name), kind) for name, kind in INTERFACES.items()]
    ours = [name for name in vars(Arm) if not name.startswith("_")]
    assert [name for name in ours if not any(hasattr(kind, name) for kind in kinds)] == []
