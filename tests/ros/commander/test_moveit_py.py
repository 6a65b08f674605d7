"""MoveIt 2's Python package `moveit` (moveit_py): scripts as they stand, and each class."""

import copy
import logging
from pathlib import Path

import numpy as np
import pytest
from trajopt.ros.commander.geometry_msgs.msg import PoseStamped
from trajopt.ros.commander.moveit_msgs.msg import (
    AttachedCollisionObject,
    CollisionObject,
    Constraints,
    MoveItErrorCodes,
    PlanningSceneWorld,
)

import trajopt as to
from tests.ros.commander.conftest import SRDF, URDF
from trajopt.files.moveit.frames import pose_of
from trajopt.ros.commander import World, moveit, rclpy
from trajopt.ros.commander.moveit.core.kinematic_constraints import (
    construct_joint_constraint,
    construct_link_constraint,
)
from trajopt.ros.commander.moveit.core.robot_model import RobotModel
from trajopt.ros.commander.moveit.core.robot_state import RobotState, robotStateToRobotStateMsg
from trajopt.ros.commander.moveit.planning import MoveItPy, PlanRequestParameters
from trajopt.ros.commander.planning_scene_interface import PlanningSceneInterface
from trajopt.ros.commander.scripts import run_script
from trajopt.server.move_group.outcome import MoveItCommanderException, NoStandIn

OURS = Path(__file__).parent / "as_they_stand" / "plan_with_moveit_py.py"
STRAIGHT = {"shoulder": 0.0, "elbow": 0.0, "wrist": 0.0}


@pytest.fixture
def robot(jumping: World) -> MoveItPy:
    return MoveItPy()


@pytest.fixture
def state(robot: MoveItPy) -> RobotState:
    return RobotState(robot.get_robot_model())


def box(name: str, x: float) -> CollisionObject:
    at = PoseStamped()
    at.header.frame_id, at.pose.position.x, at.pose.position.z = "base", x, 0.1
    return PlanningSceneInterface.make_box(name, at, (0.1, 0.1, 0.1))


def test_a_script_of_our_own(
    jumping: World, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.INFO, "trajopt.ros.commander"), pytest.raises(SystemExit) as ended:
        run_script(OURS, world=jumping)
    assert ended.value.code == 0
    told = capsys.readouterr().out
    for line in ("named", "state", "pose", "constraints", "colliding"):
        assert f"{line}: True" in told
    assert "reached: True False" in told
    said = caplog.text
    assert "lab.motions: arm: bent, straight" in said and "in collision: upper and box" in said
    assert "no planner named 'RRTConnectkConfigDefault'" in said
    assert jumping.scene.objects == {}


def test_a_missing_stand_in_error_lists_the_available_ones(jumping: World, tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    for text, said in (
        ("from rclpy.node import Node", "line 1: No module named 'rclpy.node'; stand-ins exist for"),
        ("import rclpy\nrclpy.create_node('x')", "line 2: rclpy.create_node has no stand-in: there are no"),
        (
            "from moveit.planning import MoveItPy\nMoveItPy().get_trajectory_execution_manager()",
            "line 2: MoveItPy.get_trajectory_execution_manager has no stand-in; there are: ",
        ),
        (
            "from moveit.planning import MoveItPy\nMoveItPy().get_planning_component('amr')",
            "line 2: no group named 'amr'",
        ),
    ):
        script.write_text(text)
        with pytest.raises(MoveItCommanderException) as refused:
            run_script(script, world=jumping)
        assert said in str(refused.value)


def test_goals(robot: MoveItPy, jumping: World) -> None:
    arm = robot.get_planning_component("lab_arm")
    assert arm.planning_group_name == "arm"
    assert arm.get_named_target_state_values("straight") == STRAIGHT
    for wrong in (
        {},
        {"configuration_name": "bent", "robot_state": arm.get_start_state()},
        {"pose_stamped_msg": PoseStamped()},
        {"robot_state": STRAIGHT},
        {"configuration_name": "bend"},
    ):
        with pytest.raises(MoveItCommanderException):
            arm.set_goal_state(**wrong)  # pyright: ignore[reportArgumentType]
    arm.set_goal_state(configuration_name="straight")
    result = arm.plan()
    assert result and result.planning_time > 0.0 and result.planner_id == "sqp"
    motion = result.trajectory
    assert motion.joint_model_group_name == "arm" and len(motion) > 2
    assert sum(motion.get_waypoint_durations()) == pytest.approx(motion.duration)
    assert motion.average_segment_duration == pytest.approx(motion.duration / (len(motion) - 1))
    assert list(motion)[-1].joint_positions == pytest.approx(STRAIGHT, abs=1e-3)
    assert robot.execute("arm", motion, True).status == "SUCCEEDED"
    assert jumping.named_positions == pytest.approx(STRAIGHT, abs=1e-3)
    again = robot.execute(robot_trajectory=motion, blocking=True)
    assert not again and again.status == "ABORTED"
    with pytest.raises(MoveItCommanderException, match="give one RobotTrajectory"):
        robot.execute("arm")


def test_a_plan_without_a_goal_is_refused(robot: MoveItPy) -> None:
    arm = robot.get_planning_component("arm")
    with pytest.raises(MoveItCommanderException, match="call set_goal_state"):
        arm.plan()
    with pytest.raises(MoveItCommanderException, match="is empty"):
        arm.set_goal_state(motion_plan_constraints=[])


def test_the_parameters_set_the_speed(robot: MoveItPy) -> None:
    arm, slow = robot.get_planning_component("arm"), PlanRequestParameters(robot)
    slow.max_velocity_scaling_factor = slow.max_acceleration_scaling_factor = 0.25
    arm.set_goal_state(configuration_name="straight")
    assert arm.plan(slow).trajectory.duration > 1.5 * arm.plan(parameters=None).trajectory.duration


def test_path_constraints_and_workspace(robot: MoveItPy, state: RobotState) -> None:
    arm = robot.get_planning_component("arm")
    group = robot.get_robot_model().get_joint_model_group("arm")
    arm.set_workspace(-1.0, -1.0, -1.0, 1.0, 1.0, 1.0)
    arm.unset_workspace()
    state.joint_positions = STRAIGHT
    held = construct_joint_constraint(state, group)
    arm.set_path_constraints(Constraints(joint_constraints=held.joint_constraints[2:]))
    arm.set_goal_state(motion_plan_constraints=[held])
    failed = arm.plan()
    assert not failed and failed.error_code.val == MoveItErrorCodes.START_STATE_VIOLATES_PATH_CONSTRAINTS
    assert len(failed.trajectory) == 0 and failed.trajectory.duration == 0.0


def test_states(robot: MoveItPy, state: RobotState) -> None:
    model = robot.get_robot_model()
    assert state.joint_positions == STRAIGHT and not state.dirty
    assert state.set_to_default_values("arm", "bent")
    assert state.joint_positions == pytest.approx({"shoulder": 0.5, "elbow": -1.0, "wrist": 0.2})
    other, deep = copy.copy(state), copy.deepcopy(state)
    state.joint_positions = {"wrist": 1.0}
    assert state.joint_positions["wrist"] == 1.0
    assert other.joint_positions["wrist"] == deep.joint_positions["wrist"] == 0.2
    with pytest.raises(to.TrajoptError, match="'twist'"):
        state.joint_positions = {"twist": 1.0}
    with pytest.raises(MoveItCommanderException, match="position_values"):
        state.set_joint_group_positions("arm", [0.0])
    pose, matrix = state.get_pose("hand"), state.get_global_link_transform("hand")
    assert matrix[:3, 3] == pytest.approx((pose.position.x, pose.position.y, pose.position.z))
    scene = to.Scene(model.robot)
    assert pose == pose_of(scene.placement_of("hand", state.positions))
    jacobian = state.get_jacobian("arm", np.array((0.1, 0.0, 0.0)))
    assert jacobian.shape == (6, 3)
    assert np.array_equal(jacobian, state.get_jacobian("arm", "hand", (0.1, 0.0, 0.0), False))
    step, point = np.array((1e-6, 0.0, 0.0)), np.array((0.1, 0.0, 0.0, 1.0))
    before = state.get_frame_transform("hand") @ point
    state.set_joint_group_active_positions("arm", state.get_joint_group_positions("arm") + step)
    moved = (state.get_frame_transform("hand") @ point - before) / 1e-6
    assert moved[:3] == pytest.approx(jacobian[:3, 0], abs=1e-4)
    assert robotStateToRobotStateMsg(state).joint_state.name == list(model.robot.joint_names)


def test_random_positions_are_within_limits_and_free(robot: MoveItPy, state: RobotState) -> None:
    model = robot.get_robot_model()
    group = model.get_joint_model_group("arm")
    with robot.get_planning_scene_monitor().read_only() as scene:
        for _ in range(20):
            state.set_to_random_positions()
            assert group.satisfies_position_bounds(state.get_joint_group_positions("arm").tolist())
            assert not scene.is_state_colliding(state, "arm")
    held = state.joint_positions
    state.set_to_random_positions(model.get_joint_model_group("wrist_only"))
    assert {name for name, at in state.joint_positions.items() if at != held[name]} == {"wrist"}


def test_inverse_kinematics_without_a_solution_leaves_the_state_unchanged(state: RobotState) -> None:
    wanted = state.get_pose("hand")
    for at in np.random.default_rng(0).uniform(-1.5, 1.5, (15, 3)).tolist():
        state.set_joint_group_positions("arm", at)
        wanted = state.get_pose("hand")
        state.joint_positions = STRAIGHT
        assert state.set_from_ik("arm", wanted, "hand")
        found = state.get_pose("hand").position
        assert (found.x, found.y) == pytest.approx((wanted.position.x, wanted.position.y), abs=2e-5)
    before = state.joint_positions
    wanted.position.x = 5.0
    assert not state.set_from_ik("arm", wanted, "hand") and state.joint_positions == before


def test_models(robot: MoveItPy, tmp_path: Path) -> None:
    model = robot.get_robot_model()
    assert (model.name, model.model_frame) == ("lab", "base")
    assert model.joint_model_group_names == [group.name for group in model.joint_model_groups]
    assert model.has_joint_model_group("lab_arm") and not model.has_joint_model_group("ram")
    assert "lab" in model.get_model_info() and model.end_effectors == []
    group = model.get_joint_model_group("arm")
    assert group.active_joint_model_names == ["shoulder", "elbow", "wrist"]
    assert group.joint_model_names == group.active_joint_model_names
    assert "hand" in group.link_model_names and group.eef_name == ""
    assert not group.satisfies_position_bounds([3.0, 0.0, 0.0])
    assert group.satisfies_position_bounds([2.6, 0.0, 0.0], margin=0.2)
    (tmp_path / "lab.urdf").write_text(URDF)
    (tmp_path / "lab.srdf").write_text(SRDF)
    loaded = RobotModel(str(tmp_path / "lab.urdf"), str(tmp_path / "lab.srdf"))
    assert loaded.joint_model_group_names == model.joint_model_group_names
    with pytest.raises(NoStandIn, match=r"RobotModel\.root_joint_name has no stand-in"):
        _ = model.root_joint_name


def test_link_constraints() -> None:
    made = construct_link_constraint("hand", "base", (0.1, 0.2, 0.3), 0.01, (0.0, 0.0, 0.0, 1.0), 0.02)
    (position,), (turn,) = made.position_constraints, made.orientation_constraints
    assert position.constraint_region.primitives[0].dimensions == [0.01]
    assert position.constraint_region.primitive_poses[0].position.z == 0.3
    assert turn.absolute_z_axis_tolerance == 0.02 and turn.orientation.w == 1.0
    with pytest.raises(MoveItCommanderException, match="a position, an orientation or both"):
        construct_link_constraint("hand", "base")
    with pytest.raises(MoveItCommanderException, match="cartesian_position_tolerance is missing"):
        construct_link_constraint("hand", "base", (0.0, 0.0, 0.0))
    with pytest.raises(MoveItCommanderException, match="orientation_tolerance is missing"):
        construct_link_constraint("hand", "base", orientation=(0.0, 0.0, 0.0, 1.0))


def test_the_scene(robot: MoveItPy, jumping: World, state: RobotState) -> None:
    monitor = robot.get_planning_scene_monitor()
    assert monitor.name and monitor.wait_for_current_robot_state()
    assert monitor.process_collision_object(box("near", 0.3))
    with monitor.read_write() as scene:
        scene.process_planning_scene_world(PlanningSceneWorld([box("far", 3.0)]))
        assert scene.knows_frame_transform("far") and not scene.knows_frame_transform(state, "moon")
        assert scene.get_frame_transform("far")[0, 3] == 3.0
        assert {each.id for each in scene.planning_scene_message.world.collision_objects} == {"near", "far"}
        assert scene.planning_frame == "base"
    with monitor.read_only() as scene:
        assert scene.is_state_colliding(state) and not scene.is_state_valid(state, "arm", verbose=True)
        assert not scene.is_state_colliding("arm") and scene.is_state_valid(joint_model_group_name="arm")
        group = robot.get_robot_model().get_joint_model_group("arm")
        held = construct_joint_constraint(state, group)
        assert scene.is_state_constrained(state, held)
        assert not scene.is_state_constrained(scene.current_state, held, verbose=True)
        with pytest.raises(MoveItCommanderException, match="read_write"):
            scene.remove_all_collision_objects()
    held_box = AttachedCollisionObject("hand", CollisionObject(id="near"))
    assert monitor.process_attached_collision_object(held_box)
    assert jumping.scene.holder("near").link == "hand"
    held_box.object.operation = CollisionObject.REMOVE
    assert monitor.process_attached_collision_object(held_box)
    with monitor.read_write() as scene:
        whole = scene.planning_scene_message
        scene.remove_all_collision_objects()
        assert jumping.scene.objects == {}
    assert monitor.new_planning_scene_message(whole) and set(jumping.scene.objects) == {"near", "far"}


def test_loggers(caplog: pytest.LogCaptureFixture) -> None:
    logger = rclpy.logging.get_logger("node")
    with caplog.at_level(logging.DEBUG, "trajopt.ros.commander"):
        for tell in (logger.debug, logger.info, logger.warn, logger.warning, logger.error, logger.fatal):
            tell("100 % done", once=True)
        rclpy.spin(None)
    levels = [record.levelname for record in caplog.records]
    assert levels == ["DEBUG", "INFO", "WARNING", "WARNING", "ERROR", "CRITICAL", "INFO"]
    assert caplog.records[0].getMessage() == "node: 100 % done"
    assert moveit.planning.MoveItPy is MoveItPy and rclpy.ok()
