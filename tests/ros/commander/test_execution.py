"""Motions are executed, waited for or not, stopped, and measured against their goal."""

import re
from pathlib import Path

import numpy as np
import pytest
from trajopt.ros.commander.moveit_msgs.msg import MoveItErrorCodes, RobotTrajectory

import trajopt as to
from tests.conftest import PLANAR_ARM, PLANAR_ARM_SRDF
from tests.ros.commander.conftest import Clock
from tests.ros.commander.jumping import JumpingExecutor
from trajopt import placement
from trajopt.driving import RobotState
from trajopt.ros.commander import (
    MoveGroupCommander,
    MoveItCommanderException,
    PlanningSceneInterface,
    RobotCommander,
    World,
)
from trajopt.ros.commander.conversions import stamped


def test_go_ends_at_the_goal_and_reports_the_distance(simulated: World) -> None:
    arm = MoveGroupCommander("arm")
    assert arm.get_last_outcome() is None
    arm.set_named_target("straight")
    assert arm.go() is True
    outcome = arm.get_last_outcome()
    assert outcome.reached
    assert outcome.joint_error == pytest.approx(np.abs(arm.get_current_joint_values()).max(), abs=1.1e-4)
    assert 0.0 < outcome.joint_error < 1e-3
    assert outcome.position_error < 1e-3
    assert outcome.rotation_error < 1e-3


def test_plan_then_execute(simulated: World) -> None:
    arm = MoveGroupCommander("arm")
    success, trajectory, seconds, code = arm.plan("straight")
    assert (success, code.val) == (True, MoveItErrorCodes.SUCCESS)
    assert seconds > 0.0
    assert arm.get_current_joint_values() == [0.5, -1.0, 0.2]
    assert arm.execute(trajectory) is True
    assert np.allclose(arm.get_current_joint_values(), 0.0, atol=1e-3)
    assert arm.execute(trajectory.joint_trajectory) is False
    assert "the trajectory begins at" in arm.get_last_outcome().error_code.message


def test_short_of_the_goal_is_not_reached(lab_arm: to.Robot) -> None:
    executor = JumpingExecutor(lab_arm.positions("bent"), short_by=0.02)
    arm = MoveGroupCommander("arm", world=World(lab_arm, executor=executor))
    assert arm.go("straight") is False
    outcome = arm.get_last_outcome()
    assert outcome.error_code.val == MoveItErrorCodes.CONTROL_FAILED
    assert outcome.joint_error == pytest.approx(0.02, abs=1e-9)
    assert not outcome.reached


def test_refuses_to_execute_a_missing_plan_with_a_reason(jumping: World) -> None:
    arm = MoveGroupCommander("arm")
    arm.set_pose_target([3.0, 0, 0.1, 0, 0, 0])
    assert arm.go() is False
    outcome = arm.get_last_outcome()
    assert outcome.error_code.val == MoveItErrorCodes.NO_IK_SOLUTION
    assert "2 m too short" in outcome.error_code.message
    assert jumping.executor.followed == []
    assert arm.execute(arm.plan()[1]) is False
    assert "no points" in arm.get_last_outcome().error_code.message


def test_going_without_waiting(timed: World, clock: Clock) -> None:
    arm = MoveGroupCommander("arm", world=timed)
    assert arm.go("straight", wait=False) is True
    outcome = arm.get_last_outcome()
    assert outcome.error_code.message == "the motion is under way"
    assert not outcome.reached
    assert timed.moving
    begun = arm.get_current_joint_values()
    clock.now += 1.0
    underway = arm.get_current_joint_values()
    assert np.allclose(begun, (0.5, -1.0, 0.2), atol=1e-6)
    assert -1.0 < underway[1] < 0.0
    assert arm.go("bent") is False
    assert arm.get_last_outcome().error_code.message == "another motion is under way; stop() it, or wait"
    clock.now += 60.0
    assert not timed.moving
    assert np.allclose(arm.get_current_joint_values(), 0.0, atol=1e-3)


def test_the_outcome_of_a_motion_that_was_not_waited_for(timed: World, clock: Clock) -> None:
    arm = MoveGroupCommander("arm", world=timed)
    arm.go("straight", wait=False)
    clock.now += 60.0
    assert arm.get_last_outcome().reached


def test_stop_leaves_the_arm_where_it_stopped(timed: World, clock: Clock) -> None:
    arm = MoveGroupCommander("arm", world=timed)
    arm.set_named_target("straight")
    planned = arm.plan()[1]
    arm.execute(planned, wait=False)
    clock.now += 1.0
    at_stop = np.array(arm.get_current_joint_values())
    arm.stop()
    rested = np.array(arm.get_current_joint_values())
    clock.now += 60.0
    # Physics goes on: an error of the place dies out.
    assert np.allclose(arm.get_current_joint_values(), rested, rtol=0.0, atol=1e-6)
    assert not timed.moving
    outcome = arm.get_last_outcome()
    assert outcome.error_code.val == MoveItErrorCodes.PREEMPTED
    speed = 2.0 * 0.1
    assert 0.0 < outcome.stopping_time < 0.1
    assert np.abs(rested - at_stop).max() <= speed * outcome.stopping_time
    assert "stopped within" in outcome.error_code.message
    assert "not proven" not in outcome.error_code.message
    assert outcome.joint_error == pytest.approx(np.abs(rested).max(), abs=1e-3)
    path = np.array([point.positions for point in planned.joint_trajectory.points])
    nearest = np.abs(path - rested).max(axis=1).min()
    assert nearest < 0.02
    assert arm.go("straight")


def test_stop_accepts_a_motion_that_ended_or_never_began(timed: World, clock: Clock) -> None:
    arm = MoveGroupCommander("arm", world=timed)
    arm.stop()
    assert arm.get_last_outcome() is None
    arm.go("straight", wait=False)
    clock.now += 60.0
    arm.stop()
    assert arm.get_last_outcome().reached


def test_a_scene_that_changes_while_a_motion_is_planned(lab_arm: to.Robot) -> None:
    class Meddling(JumpingExecutor):
        """Somebody puts a box down each of the first times that it is asked after being armed."""

        world: World
        boxes = 0

        def state(self) -> RobotState:
            if self.boxes > 0:
                self.boxes -= 1
                place = placement((-2.0 - self.boxes, 0, 0))
                self.world.edit(lambda scene: scene.add(f"box{self.boxes}", to.Sphere(0.1), place))
            return super().state()

    executor = Meddling(lab_arm.positions("bent"))
    world = World(lab_arm, executor=executor)
    executor.world = world
    arm = MoveGroupCommander("arm", world=world)
    arm.set_named_target("straight")
    executor.boxes = 1
    assert arm.go() is False
    changed = MoveItErrorCodes.MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE
    assert arm.get_last_outcome().error_code.val == changed
    world.edit(lambda scene: scene.remove("box0"))
    arm.allow_replanning(True)
    executor.boxes = 1
    assert arm.go() is True


def test_retiming(simulated: World) -> None:
    arm = MoveGroupCommander("arm")
    slow = arm.plan("straight")[1]
    state = RobotCommander().get_current_state()
    fast = arm.retime_trajectory(state, slow)
    slower = arm.retime_trajectory(state, slow, 0.05, 0.05, algorithm="time_optimal_trajectory_generation")
    ends = [each.joint_trajectory.points[-1] for each in (fast, slow, slower)]
    durations = [end.time_from_start.to_sec() for end in ends]
    assert durations == sorted(durations)
    assert all(np.allclose(end.positions, ends[0].positions, atol=1e-6) for end in ends)
    assert arm.execute(fast)
    with pytest.raises(MoveItCommanderException, match="there are: iterative_spline_parameterization"):
        arm.retime_trajectory(state, slow, algorithm="totg")
    with pytest.raises(MoveItCommanderException, match="has no points"):
        arm.retime_trajectory(state, RobotTrajectory())


def test_carrying(simulated: World) -> None:
    arm, scene = MoveGroupCommander("arm"), PlanningSceneInterface()
    hand = simulated.scene.placement_of("hand", simulated.positions)
    scene.add_box("part", stamped(hand * placement((0.16, 0, 0)), "base"), (0.05, 0.05, 0.05))
    assert arm.attach_object("part", touch_links=["finger"])
    assert scene.get_known_object_names() == []
    before = simulated.scene.placement_of("part", simulated.positions)
    assert arm.go("straight")
    assert arm.detach_object("part")
    assert scene.get_known_object_names() == ["part"]
    after = simulated.scene.placement_of("part", simulated.positions)
    assert np.linalg.norm(after.translation - before.translation) > 0.1
    assert arm.detach_object() is False
    with pytest.raises(MoveItCommanderException, match=r"did you mean 'part'\?"):
        arm.attach_object("prt")
    with pytest.raises(MoveItCommanderException, match="no attached object or link named 'prt'"):
        arm.detach_object("prt")


def test_a_robot_without_masses_is_moved_without_dynamics(planar_arm: to.Robot) -> None:
    arm = MoveGroupCommander("arm", world=World(planar_arm))
    assert arm.go([0.1, 0.2])
    np.testing.assert_allclose(arm.get_current_joint_values(), [0.1, 0.2], atol=1e-9)


def test_links_with_a_slash_are_frames(tmp_path: Path) -> None:
    def slashed(text: str) -> str:
        return re.sub(r'(?<=link=")|(?<=_link=")|(?<=link1=")|(?<=link2=")|(?<=<link name=")', "/", text)

    (tmp_path / "arm.urdf").write_text(slashed(PLANAR_ARM))
    (tmp_path / "arm.srdf").write_text(slashed(PLANAR_ARM_SRDF))
    arm = MoveGroupCommander("arm", world=World(to.load(tmp_path / "arm.urdf", srdf=tmp_path / "arm.srdf")))
    assert arm.get_planning_frame() == "/base"
    assert arm.go([0.1, 0.2])
    for frame in ("/base", "base"):
        pose = arm.get_current_pose()
        pose.header.frame_id = frame
        arm.set_pose_target(pose)
        assert arm.plan()[0]
