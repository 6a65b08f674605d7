"""A script drives through an executor: its own points, stops, faults, in simulated time and in real time."""

import time

import numpy as np
import pytest
from trajopt.ros.commander.moveit_msgs.msg import MoveItErrorCodes

import trajopt as to
from tests.ros.commander.conftest import Clock
from trajopt.driving import IdealExecutor, SimulatedExecutor
from trajopt.files.moveit.trajectories import trajectory_message
from trajopt.ros.commander import MoveGroupCommander, MoveItCommanderException, World


def bent_to_straight(count: int, *, duration: float, off: float = 0.0) -> np.ndarray:
    share = np.linspace(0.0, 1.0, count)[:, None]
    return np.array((0.5 + off, -1.0, 0.2)) * (1.0 - (3.0 - 2.0 * share) * share**2)


def message(arm: MoveGroupCommander, times: np.ndarray, positions: np.ndarray, **rates: np.ndarray) -> object:
    joints = ("shoulder", "elbow", "wrist")
    return trajectory_message(to.Trajectory(joints, times, positions, **rates))


@pytest.mark.parametrize("off", [0.0, 0.004])
def test_points_without_velocities_are_driven_through(simulated: World, off: float) -> None:
    """A script's own points; they may begin a little off where the robot stands."""
    arm, times = MoveGroupCommander("arm"), np.linspace(0.0, 2.0, 9)
    assert arm.execute(message(arm, times, bent_to_straight(9, duration=2.0, off=off)))
    assert arm.get_last_outcome().reached


def test_refuses_a_motion_that_does_not_end_at_rest(simulated: World) -> None:
    arm, times = MoveGroupCommander("arm"), np.array((0.0, 1.0))
    positions = np.array(((0.5, -1.0, 0.2), (0.4, -1.0, 0.2)))
    motion = message(arm, times, positions, velocities=np.array(((0.0, 0.0, 0.0), (-0.2, 0.0, 0.0))))
    assert arm.execute(motion) is False
    assert "does not end at rest" in arm.get_last_outcome().error_code.message
    assert arm.get_current_joint_values() == pytest.approx([0.5, -1.0, 0.2], abs=1e-9)


def test_a_stop_is_as_soon_as_the_limits_allow_and_proven(lab_arm: to.Robot, clock: Clock) -> None:
    """From full speed, and from a scaled one: it takes what braking takes, not a fixed time."""
    took: list[float] = []
    for scaling in (1.0, 0.1):
        executor = SimulatedExecutor(to.Scene(lab_arm), lab_arm.positions("bent"), clock=clock)
        world = World(lab_arm, executor=executor, wait=clock.wait)
        arm = MoveGroupCommander("arm", world=world)
        arm.set_max_velocity_scaling_factor(scaling)
        arm.set_max_acceleration_scaling_factor(1.0)
        success, planned, _, _ = arm.plan("straight")
        assert success
        duration = planned.joint_trajectory.points[-1].time_from_start.to_sec()
        arm.execute(planned, wait=False)
        clock.now += 0.5 * duration
        before = executor.now()
        speed = np.abs(executor.state().velocities).max()
        arm.stop()
        outcome = arm.get_last_outcome()
        assert "not proven" not in outcome.error_code.message
        limits = to.Problem(scene=to.Scene(lab_arm), group="arm", start="bent", goal="straight").limits
        assert outcome.stopping_time >= speed / limits.acceleration.max()
        end = executor.committed.end - before
        assert outcome.stopping_time == pytest.approx(end, abs=1e-9)
        took.append(outcome.stopping_time)
    assert took[1] < took[0]


def test_a_motion_faster_than_the_limits_can_be_stopped_all_the_same(timed: World, clock: Clock) -> None:
    arm, times = MoveGroupCommander("arm", world=timed), np.linspace(0.0, 0.8, 9)
    arm.execute(message(arm, times, bent_to_straight(9, duration=0.8)), wait=False)
    clock.now += 0.1  # it gathers speed at twice the acceleration that is allowed
    arm.stop()
    outcome = arm.get_last_outcome()
    assert outcome.error_code.val == MoveItErrorCodes.PREEMPTED
    assert "on its path and not proven" in outcome.error_code.message
    assert outcome.stopping_time < 0.7
    assert outcome.joint_error > 0.1


def test_a_motion_is_stopped_after_another_was_refused(timed: World, clock: Clock) -> None:
    arm = MoveGroupCommander("arm", world=timed)
    arm.go("straight", wait=False)
    clock.now += 0.5
    assert arm.go("bent") is False
    arm.stop()
    assert not timed.moving
    assert arm.get_last_outcome().error_code.val == MoveItErrorCodes.PREEMPTED
    assert np.abs(timed.executor.state().velocities).max() < 1e-3


def test_a_fault_is_reported_and_blocks_motion_until_cleared(timed: World, clock: Clock) -> None:
    arm = MoveGroupCommander("arm", world=timed)
    arm.go("straight", wait=False)
    clock.now += 0.5
    timed.executor.stop()
    clock.now += 1.0
    outcome = arm.get_last_outcome()
    assert outcome.error_code.val == MoveItErrorCodes.CONTROL_FAILED
    assert "the driver stopped the robot" in outcome.error_code.message
    assert arm.go("straight") is False
    assert "clear_fault" in arm.get_last_outcome().error_code.message
    timed.executor.clear_fault()
    assert arm.go("straight")


def test_in_real_time(lab_arm: to.Robot) -> None:
    """The clock goes on while a stop is worked out: it is offered again, later, until it is in time."""
    executor = SimulatedExecutor(to.Scene(lab_arm), lab_arm.positions("bent"), clock=time.monotonic)
    world = World(lab_arm, executor=executor)
    arm = MoveGroupCommander("arm", world=world)
    arm.set_max_velocity_scaling_factor(0.2)
    arm.go("straight", wait=False)
    time.sleep(0.3)
    assert world.moving
    arm.stop()
    assert not world.moving
    outcome = arm.get_last_outcome()
    assert outcome.error_code.val == MoveItErrorCodes.PREEMPTED
    assert executor.fault() == ""
    assert "not proven" not in outcome.error_code.message
    assert arm.go("straight")


def test_an_executor_of_another_robot(lab_arm: to.Robot) -> None:
    with pytest.raises(MoveItCommanderException, match="no joint named 'shouldr' \\(did you mean 'shoulder'"):
        World(lab_arm, executor=IdealExecutor(("shouldr",), np.zeros(1)))


def test_joints_that_the_executor_does_not_drive_stand(lab_arm: to.Robot) -> None:
    executor = IdealExecutor(("shoulder", "elbow"), np.array((0.5, -1.0)))
    world = World(lab_arm, executor=executor, wait=executor.advance)
    assert world.positions.tolist() == [0.5, -1.0, 0.2]
    arm = MoveGroupCommander("arm", world=world)
    assert arm.go("straight") is False
    assert arm.get_last_outcome().error_code.message == "wrist is not driven here"
