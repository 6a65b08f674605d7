"""What a script sets about planning, and what planning makes of it."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from trajopt.ros.commander.moveit_msgs.msg import (
    Constraints,
    JointConstraint,
    MoveItErrorCodes,
    OrientationConstraint,
    PositionConstraint,
    RobotState,
    TrajectoryConstraints,
    VisibilityConstraint,
)
from trajopt.ros.commander.sensor_msgs.msg import JointState
from trajopt.ros.commander.shape_msgs.msg import SolidPrimitive

from trajopt import placement
from trajopt.ros.commander import MoveGroupCommander, MoveItCommanderException, PlanningSceneInterface, World
from trajopt.ros.commander.conversions import stamped


@pytest.fixture
def arm(jumping: World) -> MoveGroupCommander:
    return MoveGroupCommander("arm", world=jumping)


def positions_of(trajectory: object) -> np.ndarray:
    return np.array([point.positions for point in trajectory.joint_trajectory.points])


def test_defaults_are_moveits(arm: MoveGroupCommander) -> None:
    request = arm.construct_motion_plan_request()
    assert arm.get_goal_tolerance() == (1e-4, 1e-4, 1e-3)
    assert (request.allowed_planning_time, request.num_planning_attempts) == (5.0, 1)
    assert (request.max_velocity_scaling_factor, request.max_acceleration_scaling_factor) == (0.1, 0.1)
    assert request.start_state.is_diff


def test_setters_show_in_the_request(arm: MoveGroupCommander) -> None:
    arm.set_goal_tolerance(0.02)
    arm.set_planning_time(2.5)
    arm.set_num_planning_attempts(3)
    arm.set_planner_id("sqp-piqp")
    arm.set_planning_pipeline_id("trajopt")
    arm.set_workspace([-1, -2, 1, 2])
    arm.limit_max_cartesian_link_speed(0.3, "fore")
    request = arm.construct_motion_plan_request()
    assert arm.get_goal_tolerance() == (0.02, 0.02, 0.02)
    assert (arm.get_planning_time(), request.allowed_planning_time) == (2.5, 2.5)
    assert request.num_planning_attempts == 3
    assert request.planner_id == arm.get_planner_id() == "sqp-piqp"
    assert (request.cartesian_speed_limited_link, request.max_cartesian_speed) == ("fore", 0.3)
    low, high = request.workspace_parameters.min_corner, request.workspace_parameters.max_corner
    assert (low.x, low.y, low.z, high.x, high.y, high.z) == (-1, -2, 0, 1, 2, 0)
    arm.clear_max_cartesian_link_speed()
    assert arm.construct_motion_plan_request().max_cartesian_speed == 0.0
    assert arm.get_interface_description().planner_ids[0] == "sqp"


def test_scaling_slows_the_motion(arm: MoveGroupCommander) -> None:
    arm.set_named_target("straight")
    duration: list[float] = []
    for factor in (0.1, 1.0):
        arm.set_max_velocity_scaling_factor(factor)
        arm.set_max_acceleration_scaling_factor(factor)
        trajectory = arm.plan()[1]
        duration.append(trajectory.joint_trajectory.points[-1].time_from_start.to_sec())
        speeds = np.abs([point.velocities for point in trajectory.joint_trajectory.points])
        assert speeds.max() <= 2.0 * factor * (1 + 1e-6)
    assert duration[0] > 3.0 * duration[1]


def test_speed_of_a_link(arm: MoveGroupCommander, jumping: World) -> None:
    arm.set_named_target("straight")
    arm.set_max_velocity_scaling_factor(1.0)
    arm.set_max_acceleration_scaling_factor(1.0)
    arm.limit_max_cartesian_link_speed(0.2)
    points = arm.plan()[1].joint_trajectory.points
    for point in points[:: len(points) // 12]:
        jacobian = np.array(arm.get_jacobian_matrix(point.positions))
        assert np.linalg.norm(jacobian[:3] @ point.velocities) <= 0.2 * (1 + 1e-3)


def test_attempts_take_the_shortest(arm: MoveGroupCommander) -> None:
    arm.set_pose_target([0.6, 0.5, 0.1, 0, 0, 0.8])
    once = arm.plan()[1].joint_trajectory.points[-1].time_from_start.to_sec()
    arm.set_num_planning_attempts(4)
    assert arm.plan()[1].joint_trajectory.points[-1].time_from_start.to_sec() <= once + 1e-9


def test_path_constraints_are_kept_by_plan_and_go(arm: MoveGroupCommander, jumping: World) -> None:
    near = JointConstraint("wrist", 0.2, 0.25, 0.25, 1.0)
    arm.set_path_constraints(Constraints(name="still", joint_constraints=[near]))
    arm.set_pose_target([0.9, 0.35, 0.1, 0, 0, 0.35])
    assert arm.get_path_constraints().name == "still"
    success, trajectory, _, code = arm.plan()
    assert success, code.message
    assert np.abs(positions_of(trajectory)[:, 2] - 0.2).max() <= 0.25 + 1e-6
    assert arm.go(), arm.get_last_outcome()
    (followed,) = jumping.executor.followed
    assert np.abs(followed(np.linspace(0, followed.duration, 300))[:, 2] - 0.2).max() <= 0.25 + 1e-6
    arm.set_named_target("straight")
    arm.set_joint_value_target("wrist", -0.5)
    assert not arm.go()
    assert arm.get_last_outcome().error_code.val == MoveItErrorCodes.GOAL_VIOLATES_PATH_CONSTRAINTS
    arm.set_path_constraints(None)
    assert arm.go()


def test_position_orientation_and_visibility_constraints(arm: MoveGroupCommander, jumping: World) -> None:
    box = PositionConstraint(link_name="hand")
    box.constraint_region.primitives = [SolidPrimitive(SolidPrimitive.BOX, [4.0, 4.0, 0.01])]
    box.constraint_region.primitive_poses = [stamped(placement((0, 0, 0.1)), "").pose]
    upright = OrientationConstraint(
        link_name="hand",
        absolute_x_axis_tolerance=0.1,
        absolute_y_axis_tolerance=0.1,
        absolute_z_axis_tolerance=3.2,
    )
    seen = VisibilityConstraint(
        target_pose=stamped(placement((5.0, 2.0, 0.1)), "base"),
        max_range_angle=0.6,
        target_radius=0.1,
        cone_sides=4,
        sensor_view_direction=VisibilityConstraint.SENSOR_X,
    )
    seen.sensor_pose.header.frame_id = "hand"
    arm.set_joint_value_target([0.4, 0.2, -0.3])
    jumping.executor.stand_at(jumping.robot.positions({"shoulder": -0.8, "elbow": 0.9, "wrist": 0.2}))
    arm.set_path_constraints(
        Constraints(
            position_constraints=[box], orientation_constraints=[upright], visibility_constraints=[seen]
        )
    )
    success, trajectory, _, code = arm.plan()
    assert success, code.message
    for row in positions_of(trajectory):
        at = jumping.scene.placement_of(
            "hand", jumping.robot.positions(dict(zip(arm.get_active_joints(), row, strict=True)))
        )
        way = np.array((5.0, 2.0, 0.1)) - at.translation
        assert np.arccos(at.rotation[:, 0] @ way / np.linalg.norm(way)) <= 0.6 + 1e-6


def test_trajectory_constraints_are_waypoints(arm: MoveGroupCommander, jumping: World) -> None:
    over = Constraints(joint_constraints=[JointConstraint("elbow", 0.9, 0.01, 0.01, 1.0)])
    arm.set_trajectory_constraints(TrajectoryConstraints([over]))
    arm.set_named_target("straight")
    success, trajectory, _, code = arm.plan()
    assert success, code.message
    assert np.abs(positions_of(trajectory)[:, 1] - 0.9).min() < 0.05
    arm.clear_trajectory_constraints()
    assert arm.get_trajectory_constraints().constraints == []
    assert positions_of(arm.plan()[1])[:, 1].max() < 0.1


def test_stored_constraints(arm: MoveGroupCommander, constraints_folder: Path) -> None:
    arm.set_constraints_database(str(constraints_folder), 33829)
    assert arm.get_known_constraints() == ["still"]
    arm.set_path_constraints("still")
    (kept,) = arm.get_path_constraints().joint_constraints
    assert (kept.joint_name, kept.tolerance_above) == ("wrist", 0.5)
    with pytest.raises(MoveItCommanderException, match="there are: still"):
        arm.set_path_constraints("stil")


def test_start_state(arm: MoveGroupCommander) -> None:
    arm.set_named_target("straight")
    arm.set_start_state(RobotState(JointState(name=["elbow"], position=[0.7])))
    first = positions_of(arm.plan()[1])[0]
    assert np.allclose(first, (0.5, 0.7, 0.2))
    assert not arm.go()
    outcome = arm.get_last_outcome()
    assert outcome.error_code.val == MoveItErrorCodes.CONTROL_FAILED
    assert (
        "joint 'elbow' stands at -57.3 deg (-1.0000 rad), but the trajectory begins at 40.11 deg (0.7000 rad)"
        in outcome.error_code.message
    )
    arm.set_start_state_to_current_state()
    assert arm.go()


def test_a_bad_start_is_named(arm: MoveGroupCommander, jumping: World) -> None:
    arm.set_named_target("straight")
    arm.set_start_state(RobotState(JointState(name=["elbow"], position=[2.7])))
    success, trajectory, _, code = arm.plan()
    assert (success, trajectory.joint_trajectory.points) == (False, [])
    assert code.val == MoveItErrorCodes.START_STATE_INVALID
    assert "elbow at 154.7 deg (2.7000 rad) is 11.46 deg outside [-143.2, 143.2] deg" in code.message
    arm.set_start_state_to_current_state()
    PlanningSceneInterface(world=jumping).add_box(
        "wall", stamped(placement((0.26, 0.14, 0.1)), "base"), (0.1,) * 3
    )
    code = arm.plan()[3]
    assert code.val == MoveItErrorCodes.START_STATE_IN_COLLISION
    assert "inside wall" in code.message
    with pytest.raises(MoveItCommanderException, match="there are: elbow, shoulder, wrist"):
        arm.set_start_state(RobotState(JointState(name=["elbo"], position=[0.7])))


@pytest.mark.parametrize(
    ("misuse", "said"),
    [
        (lambda arm: arm.set_max_velocity_scaling_factor(0.0), r"must lie in \(0, 1\]"),
        (lambda arm: arm.set_max_acceleration_scaling_factor(1.1), "acceleration scaling"),
        (lambda arm: arm.set_planning_time(0.0), "planning time must be positive"),
        (lambda arm: arm.set_num_planning_attempts(0), "one attempt at least"),
        (lambda arm: arm.set_planner_id("RRTConnect"), "no planner named 'RRTConnect'.*sqp-osqp"),
        (lambda arm: arm.set_planning_pipeline_id("ompl"), "there are: trajopt"),
        (lambda arm: arm.set_workspace([1, 2, 3]), "0, 4 or 6 numbers"),
        (lambda arm: arm.limit_max_cartesian_link_speed(0.0), "must be positive"),
        (lambda arm: arm.set_support_surface_name("table"), "there are: none"),
        (lambda arm: arm.set_constraints_database("/nowhere", 0), "is not a folder"),
        (lambda arm: arm.set_end_effector_link("hnad"), r"did you mean 'hand'\?"),
        (lambda arm: arm.set_pose_reference_frame("tabel"), "no frame named 'tabel'"),
        (
            lambda arm: arm.set_path_constraints(Constraints(joint_constraints=[JointConstraint("elbo")])),
            r"joint_constraints\[0\].joint_name in set_path_constraints",
        ),
        (
            lambda arm: arm.set_trajectory_constraints(
                TrajectoryConstraints([Constraints(position_constraints=[PositionConstraint()])])
            ),
            "set_trajectory_constraints",
        ),
    ],
)
def test_misuse_raises_immediately(arm: MoveGroupCommander, misuse: Callable[..., None], said: str) -> None:
    before = arm.construct_motion_plan_request()
    with pytest.raises(MoveItCommanderException, match=said):
        misuse(arm)
    assert arm.construct_motion_plan_request() == before
