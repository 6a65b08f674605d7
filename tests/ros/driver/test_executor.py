"""The executor for FollowJointTrajectory, through our bridge, with a stand-in of ros2_control."""

import json
import threading
import time
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
from websockets.sync.server import ServerConnection, serve

import trajopt as to
from tests.ros.driver.controller import BEGIN, JOINTS, Controller, bridge, controlled
from trajopt.driving import EventKind, Executor, Supervisor, SupervisorOptions, conformance
from trajopt.files.messages import Generation
from trajopt.ros.driver import FollowJointTrajectoryExecutor
from trajopt.values.errors import ExecutionError, ProblemError, ShapeError

LATENCY = 0.3
"""Long enough for a machine that does much else [s]."""


STATES = "/arm/joint_states"


@pytest.fixture(scope="module")
def url(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of a bridge."""
    with bridge(tmp_path_factory.mktemp("bridge")) as address:
        yield address


def executor(url: str, **stated: Any) -> FollowJointTrajectoryExecutor:
    options: dict[str, Any] = {"latency": LATENCY, "silence": 5.0, "tolerance": 1e-4, "joint_states": STATES}
    return FollowJointTrajectoryExecutor(url, JOINTS, **{**options, **stated})


@contextmanager
def driven(url: str, **stated: Any) -> Generator[tuple[FollowJointTrajectoryExecutor, Controller]]:
    with controlled(url, stated.get("generation", Generation.ROS2)) as controller:
        names = {"action": controller.action, "joint_states": controller.states}
        with executor(url, **names, **stated) as arm:
            yield arm, controller


def motion(begin: tuple[float, ...], end: tuple[float, ...], duration: float = 0.5) -> to.Trajectory:
    still = np.zeros((2, len(begin)))
    return to.Trajectory(JOINTS, np.array((0.0, duration)), np.array((begin, end)), still, still)


def until(holds: Callable[[], object]) -> None:
    """Wait for something that will be so."""
    for _ in range(3000):
        if holds():
            return
        time.sleep(0.01)
    raise AssertionError("it was not so within 30 s")


def test_conforms(url: str) -> None:
    with driven(url) as (arm, controller):
        assert isinstance(arm, Executor)
        broken = [str(rule) for rule in conformance(arm, time.sleep, duration=0.5) if not rule.holds]
        assert broken == []
        assert {len(goal["trajectory"]["joint_names"]) for goal in controller.goals} == {3}


def test_in_ros_1_goals_are_topics_of_actionlib(url: str) -> None:
    with driven(url, generation=Generation.ROS1) as (arm, _):
        begin = arm.now() + 2.0 * LATENCY
        assert arm.splice(motion(BEGIN, (0.6, -1.0, 0.2)), begin) == ""
        until(lambda: arm.now() > begin + 0.6)
        assert arm.fault() == "" and arm.state().positions == pytest.approx((0.6, -1.0, 0.2))
        begin = arm.now() + 2.0 * LATENCY
        assert arm.splice(motion((0.6, -1.0, 0.2), BEGIN, 2.0), begin) == ""
        until(lambda: arm.now() > begin + 0.5)
        arm.stop()
        until(lambda: not arm.state().velocities.any())
        assert arm.fault() == "it was stopped" and arm.state().positions[0] > 0.51


def test_a_goal_holds_the_rest_of_the_motion_under_way(url: str) -> None:
    first, then = motion(BEGIN, (0.6, -1.0, 0.2), 2.0), motion((0.6, -1.0, 0.2), (0.6, -0.9, 0.2))
    with driven(url) as (arm, controller):
        begin = arm.now() + 2.0 * LATENCY
        assert arm.splice(first, begin) == ""
        assert arm.splice(then, begin + 3.0) == ""
        until(lambda: len(controller.goals) == 2)
        points = controller.goals[-1]["trajectory"]["points"]
        moments = [point["time_from_start"] for point in points]
        assert moments[-1]["sec"] >= 3 and points[-1]["positions"] == pytest.approx([0.6, -0.9, 0.2])
        assert points[0]["positions"] == pytest.approx(BEGIN)
        until(lambda: arm.now() > begin + 3.6)
        assert arm.state().positions == pytest.approx((0.6, -0.9, 0.2)) and arm.fault() == ""


def test_a_command_refused_by_the_controller_is_a_fault(url: str) -> None:
    with driven(url) as (arm, controller):
        controller.broken = "joint limits"
        assert arm.splice(motion(BEGIN, (0.6, -1.0, 0.2)), arm.now() + 2.0 * LATENCY) == ""
        until(arm.fault)
        assert arm.fault() == "the controller gave up: joint limits"
        controller.broken = ""
        arm.clear_fault()
        begin = arm.now() + 2.0 * LATENCY
        assert arm.splice(motion(BEGIN, (0.6, -1.0, 0.2)), begin) == ""
        until(lambda: arm.now() > begin + 0.6)
        assert arm.fault() == "" and arm.state().positions == pytest.approx((0.6, -1.0, 0.2))


def test_silence_is_a_fault_that_stays_while_it_lasts(url: str) -> None:
    with driven(url, silence=0.5) as (arm, controller):
        controller.silent = True
        until(arm.fault)
        assert f"the last message of {controller.states} is " in arm.fault()
        assert "s old" in arm.splice(motion(BEGIN, (0.6, -1.0, 0.2)), arm.now() + 2.0 * LATENCY)
        with pytest.raises(ExecutionError, match="the fault stays"):
            arm.clear_fault()
        controller.silent = False
        until(lambda: not arm.fault())


def test_velocities_that_are_not_stated_are_differences(url: str) -> None:
    with driven(url) as (arm, controller):
        controller.stated = lambda message: {**message, "velocity": []}
        begin = arm.now() + 2.0 * LATENCY
        assert arm.splice(motion(BEGIN, (0.9, -1.0, 0.2), 2.0), begin) == ""
        until(lambda: arm.state().stamp > begin + 0.8)
        state = arm.state()
        assert 0.2 < state.velocities[0] < 0.4 and state.velocities[1:] == pytest.approx((0.0, 0.0))


def test_a_supervisor_drives_through_it(url: str, lab_arm: to.Robot) -> None:
    goal = {"shoulder": 1.0, "elbow": -0.6, "wrist": 0.2}
    problem = to.Problem(scene=to.Scene(lab_arm), group="arm", start=np.array(BEGIN), goal=goal)
    with driven(url) as (arm, controller):
        supervisor = Supervisor(arm, problem, SupervisorOptions(ahead=1.0))
        supervisor.go(problem)
        while supervisor.busy:
            supervisor.cycle()
            time.sleep(0.02)
        assert supervisor.events[-1].kind is EventKind.REACHED, supervisor.events
        assert arm.state().positions == pytest.approx(list(goal.values()), abs=1e-3)
        assert len(controller.goals) > 1


@contextmanager
def speaking(*messages: str, stays: bool = True) -> Generator[str]:
    """Run another server, which sends joint states, messages, and perhaps leaves; yield its address."""
    joints = {"name": JOINTS, "position": BEGIN, "velocity": [None] * 3, "effort": [None] * 3}

    def talk(socket: ServerConnection) -> None:
        stamp = dict(zip(("sec", "nanosec"), divmod(time.time_ns(), 10**9), strict=True))
        state = {"header": {"stamp": stamp}, **joints}
        socket.send(json.dumps({"op": "publish", "topic": STATES, "msg": state}))
        for message in messages:
            socket.send(message)
        for _ in socket if stays else ():
            pass

    with serve(talk, "127.0.0.1", 0) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"ws://127.0.0.1:{server.socket.getsockname()[1]}"
        finally:
            server.shutdown()
            thread.join()


LATER = {"header": {"stamp": {"sec": 2**31, "nanosec": 0}}, "name": JOINTS, "position": [None, 0.0, 0.0]}


NOTHING = json.dumps({"op": "publish", "topic": STATES, "msg": 3})


@pytest.mark.parametrize(
    "message",
    ["no JSON", "[]", json.dumps({"op": "publish", "topic": STATES, "msg": LATER}), NOTHING],
)
def test_numbers_may_be_missing_but_positions(message: str) -> None:
    with speaking() as url, executor(url) as arm:
        assert arm.fault() == "" and not arm.state().velocities.any()
    with speaking(message) as url, executor(url) as arm:
        until(arm.fault)
        assert "rosbridge sent a message that cannot be read" in arm.fault()


def test_a_connection_that_is_lost_is_a_fault() -> None:
    with speaking(stays=False) as url, executor(url) as arm:
        until(arm.fault)
        assert "clos" in arm.fault()
        assert "clos" in arm.splice(motion(BEGIN, (0.6, -1.0, 0.2)), arm.now() + 2.0 * LATENCY)
        with pytest.raises(ExecutionError, match="make another executor"):
            arm.clear_fault()


def test_refuses_trajectories_it_cannot_drive(url: str) -> None:
    with pytest.raises(ExecutionError, match=r"cannot connect to 'ws://127\.0\.0\.1:9'"):
        executor("ws://127.0.0.1:9")
    with pytest.raises(ExecutionError, match="cannot connect"):
        executor("no address")
    with pytest.raises(ProblemError, match="latency must be positive"):
        executor("ws://127.0.0.1:9", latency=0.0)
    with pytest.raises(ProblemError, match="tolerance must not be negative"):
        executor("ws://127.0.0.1:9", tolerance=-1e-3)
    with pytest.raises(ShapeError, match="tolerance"):
        executor("ws://127.0.0.1:9", tolerance=np.array((1e-3, np.nan, 1e-3)))
    base = tuple(f"world_joint/{name}" for name in ("x", "y", "theta"))
    with pytest.raises(ProblemError, match=r"does not drive a base \(world_joint\)"):
        FollowJointTrajectoryExecutor("ws://127.0.0.1:9", base, tolerance=1e-3)
    with controlled(url) as controller:
        controller.stated = lambda message: {**message, "header": {"stamp": {"sec": 0, "nanosec": 0}}}
        with pytest.raises(ExecutionError, match="no message with all joints and a stamp came in 1 s"):
            executor(url, timeout=1.0, joint_states=controller.states)
