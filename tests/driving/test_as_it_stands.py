"""Proofs and motions use the state of the robot, not the start of a problem."""

import pickle
from multiprocessing import Pipe
from pathlib import Path
from threading import Thread

import numpy as np
import pytest

import trajopt as to
from trajopt.driving import EventKind, IdealExecutor, Servo, SimulatedExecutor, Supervisor
from trajopt.driving.motion_guard import guard_of
from trajopt.driving.remote import RemoteExecutor, attend
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.values.errors import ExecutionError, ProblemError

JOINT = """
<joint name="{name}" type="prismatic"><parent link="base"/><child link="{name}_link"/><axis xyz="{axis}"/>
<limit lower="-2" upper="2" velocity="1" effort="100"/></joint>
<link name="{name}_link"><inertial><mass value="1"/><origin xyz="0 0 0"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><sphere radius="0.2"/></geometry></collision></link>"""
URDF = f"""<robot name="crossing"><link name="base"/>
{JOINT.format(name="along", axis="1 0 0")}{JOINT.format(name="across", axis="0 1 0")}</robot>"""
SRDF = """<robot name="crossing">
<group name="one"><joint name="along"/></group><group name="other"><joint name="across"/></group></robot>"""


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    folder = tmp_path_factory.mktemp("crossing")
    (folder / "crossing.urdf").write_text(URDF)
    (folder / "crossing.srdf").write_text(SRDF)
    return to.load(folder / "crossing.urdf", srdf=folder / "crossing.srdf")


def across(robot: to.Robot, other: float) -> to.Problem:
    """One carriage passes where the other may stand."""
    return to.Problem(
        scene=to.Scene(robot),
        group="one",
        start={"along": -1.0, "across": other},
        goal=to.joint_positions({"along": 1.0}),
    )


def test_joints_outside_the_group_stay_where_the_executor_has_them(robot: to.Robot) -> None:
    said, there = across(robot, 1.0), across(robot, 0.0)
    motion = to.plan(said).require().trajectory
    arm = IdealExecutor(robot.joint_names, there.start_positions)
    assert not guard_of(said, arm).proven(motion, WorldSnapshot(said.scene, 0.0), 0.0)
    supervisor = Supervisor(arm, said)
    supervisor.go(said)
    for _ in range(20):
        supervisor.cycle()
        arm.advance(0.02)
    assert supervisor.blocked
    assert EventKind.STARTED not in [event.kind for event in supervisor.events]


def test_second_stop_does_not_move_the_robot(robot: to.Robot) -> None:
    problem = across(robot, 1.0)
    arm = SimulatedExecutor(problem.scene, problem.start_positions)
    assert not arm.splice(to.plan(problem).require().trajectory, 0.01)
    arm.advance(0.8)
    arm.stop()
    arm.advance(0.5)
    stands = arm.truth().positions
    arm.stop()
    arm.advance(0.5)
    assert arm.truth().positions == pytest.approx(stands, abs=1e-3)
    assert arm.fault()


def test_refused_recovery_does_not_clear_the_fault(robot: to.Robot) -> None:
    problem = across(robot, 1.0)
    arm = SimulatedExecutor(problem.scene, problem.start_positions)
    supervisor = Supervisor(arm, problem)
    supervisor.go(problem)
    while arm.now() < 0.8:
        supervisor.cycle()
        arm.advance(0.02)
    assert np.abs(arm.truth().velocities).max() > 0.1
    arm.stop()
    with pytest.raises(ProblemError, match="moving"):
        supervisor.recover({"along": -1.0})
    assert arm.fault()
    arm.advance(1.0)
    for wrong in ({"scaling": 2.0}, {"goal": {"nothing": 1.0}}):
        with pytest.raises(to.TrajoptError):
            supervisor.recover(**{"goal": {"along": -1.0}, **wrong})
        assert arm.fault()


class Broken(IdealExecutor):
    """A driver whose robot has to be switched on by hand."""

    def clear_fault(self) -> None:
        raise ExecutionError("somebody has to press the button")

    def stop(self) -> None:
        raise OSError("the bus is off")


def test_remote_executor_survives_and_reports_errors() -> None:
    ours, theirs = Pipe()
    arm, attended = Broken(("joint",), np.zeros(1)), list[bool]()

    def drive() -> None:
        while attend(arm, ours, wait=30.0):
            attended.append(True)

    driving = Thread(target=drive)
    driving.start()
    remote = RemoteExecutor(theirs)
    with pytest.raises(ExecutionError, match="press the button"):
        remote.clear_fault()
    with pytest.raises(ExecutionError, match="the bus is off"):
        remote.stop()
    assert remote.now() == 0.0
    theirs.close()
    driving.join(30.0)
    assert not driving.is_alive() and attended


def test_answer_to_an_interrupted_request_is_dropped() -> None:
    ours, theirs = Pipe()
    arm = IdealExecutor(("joint",), np.zeros(1))

    class Interrupted:
        """A connection in which the user interrupts once, before the answer is there."""

        once = True

        def send(self, message: object) -> None:
            theirs.send(message)

        def recv(self) -> object:
            attend(arm, ours)
            if self.once:
                self.once = False
                raise KeyboardInterrupt
            return theirs.recv()

    connection = Interrupted()
    connection.once = False
    remote = RemoteExecutor(connection)  # type: ignore[arg-type]
    connection.once = True
    with pytest.raises(KeyboardInterrupt):
        remote.state()
    assert remote.fault() == ""
    assert remote.now() == 0.0


@pytest.mark.parametrize("kind", [Supervisor, Servo])
def test_refused_scene_of_another_robot_names_both_robots(
    kind: type[Supervisor] | type[Servo], robot: to.Robot, tmp_path: Path
) -> None:
    (tmp_path / "other.urdf").write_text(URDF.replace('name="crossing"', 'name="other"'))
    (tmp_path / "other.srdf").write_text(SRDF.replace('name="crossing"', 'name="other"'))
    other = to.load(tmp_path / "other.urdf", srdf=tmp_path / "other.srdf")
    problem = across(robot, 1.0)
    driver = kind(IdealExecutor(robot.joint_names, problem.start_positions), problem)
    told, events = driver.world, list(driver.events)
    with pytest.raises(ProblemError, match=r"contains the robot 'other', but 'crossing' is driven"):
        driver.see(to.Scene(other))
    assert driver.world is told and list(driver.events) == events


def test_scene_from_another_process_is_accepted(robot: to.Robot) -> None:
    problem = across(robot, 1.0)
    driver = Supervisor(IdealExecutor(robot.joint_names, problem.start_positions), problem)
    copy = pickle.loads(pickle.dumps(problem.scene.add("far", to.Box(1, 1, 1), to.placement((9, 0, 0)))))
    assert copy.robot is not robot
    driver.see(copy)
    assert driver.world.scene is copy
