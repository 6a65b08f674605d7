"""The robot through MoveIt's interface: names, states, joints, links."""

import numpy as np
import pytest
from trajopt.ros.commander.moveit_msgs.msg import RobotState
from trajopt.ros.commander.sensor_msgs.msg import JointState
from trajopt.ros.commander.visualization_msgs.msg import Marker

from trajopt.ros.commander import MoveGroupCommander, MoveItCommanderException, RobotCommander, World


@pytest.fixture
def robot(jumping: World) -> RobotCommander:
    return RobotCommander(world=jumping)


def test_names(robot: RobotCommander) -> None:
    assert robot.get_planning_frame() == robot.get_root_link() == "base"
    assert robot.get_group_names() == ["arm", "wrist_only"]
    assert robot.has_group("arm")
    assert not robot.has_group("leg")
    assert robot.get_joint_names() == ["shoulder", "elbow", "wrist", "mount"]
    assert robot.get_active_joint_names() == ["shoulder", "elbow", "wrist"]
    assert robot.get_active_joint_names("wrist_only") == ["wrist"]
    assert robot.get_joint_names("wrist_only") == ["wrist"]
    assert robot.get_link_names() == ["base", "upper", "fore", "hand", "finger"]
    assert robot.get_link_names("wrist_only") == ["hand"]
    assert robot.get_default_owner_group("wrist") == "wrist_only"
    assert robot.get_default_owner_group("mount") is None


def test_group_names(jumping: World) -> None:
    arm = MoveGroupCommander("arm")
    assert arm.get_name() == "arm"
    assert arm.get_active_joints() == arm.get_joints() == ["shoulder", "elbow", "wrist"]
    assert arm.get_variable_count() == 3
    assert arm.has_end_effector_link()
    assert arm.get_end_effector_link() == "hand"
    assert arm.get_planning_frame() == arm.get_pose_reference_frame() == "base"


def test_states(robot: RobotCommander, jumping: World) -> None:
    assert robot.get_current_variable_values() == {"shoulder": 0.5, "elbow": -1.0, "wrist": 0.2}
    assert robot.get_current_state().joint_state.position == [0.5, -1.0, 0.2]
    arm = MoveGroupCommander("arm")
    x, y = 0.5 * np.cos(0.5) + 0.5 * np.cos(-0.5), 0.5 * np.sin(0.5) + 0.5 * np.sin(-0.5)
    pose = arm.get_current_pose()
    assert (pose.header.frame_id, pose.pose.position.x) == ("base", pytest.approx(x))
    assert pose.pose.position.y == pytest.approx(y)
    assert arm.get_current_rpy() == pytest.approx([0, 0, -0.3])
    assert robot.get_link("hand").pose().pose == pose.pose


def test_bounds_are_enforced(jumping: World) -> None:
    arm = MoveGroupCommander("arm")
    beyond = RobotState(JointState(name=["elbow", "wrist"], position=[9.0, 0.1]))
    assert arm.enforce_bounds(beyond).joint_state.position == [2.5, 0.1]
    assert arm.get_current_state_bounded().joint_state == arm.get_current_state().joint_state


def test_jacobian_is_the_derivative_of_the_pose(jumping: World) -> None:
    arm, at = MoveGroupCommander("arm"), np.array((0.3, -0.8, 0.4))
    point = np.array((0.1, 0.05, 0.02))

    def reached(values: np.ndarray) -> np.ndarray:
        positions = jumping.robot.positions(dict(zip(arm.get_active_joints(), values, strict=True)))
        return jumping.scene.placement_of("hand", positions) * point

    jacobian = np.array(arm.get_jacobian_matrix(at.tolist(), point.tolist()))
    assert jacobian.shape == (6, 3)
    for joint in range(3):
        step = 1e-6 * np.eye(3)[joint]
        slope = (reached(at + step) - reached(at - step)) / 2e-6
        assert np.allclose(jacobian[:3, joint], slope, atol=1e-8)
    assert np.allclose(jacobian[3:], [[0, 0, 0], [0, 0, 0], [1, 1, 1]], atol=1e-12)
    assert np.allclose(np.array(arm.get_jacobian_matrix(at.tolist()))[3:], jacobian[3:])


def test_joints_and_links_are_attributes(robot: RobotCommander) -> None:
    assert robot.arm is robot.get_group("arm")
    assert robot.elbow.value() == robot.get_joint("elbow").value() == -1.0
    assert robot.elbow.bounds() == [robot.elbow.min_bound(), robot.elbow.max_bound()] == [-2.5, 2.5]
    assert robot.elbow.variable_count() == 1
    assert robot.mount.variable_count() == 0
    assert robot.mount.bounds() == []
    assert robot.fore.name() == "fore"
    assert robot.wrist.move(0.7)
    assert robot.wrist.value() == pytest.approx(0.7, abs=1e-4)
    with pytest.raises(AttributeError, match="no attribute, group, joint or link 'leg'"):
        _ = robot.leg


@pytest.mark.parametrize("ask", ["get_joint", "get_link", "get_group", "get_joint_names", "get_link_names"])
def test_unknown_names_list_those_that_exist(robot: RobotCommander, ask: str) -> None:
    with pytest.raises(MoveItCommanderException, match="there are: "):
        getattr(robot, ask)("leg")


def test_markers(robot: RobotCommander) -> None:
    found = robot.get_robot_markers().markers
    assert [marker.ns for marker in found] == robot.get_link_names()
    assert {marker.type for marker in found} == {Marker.CUBE}
    assert found[1].scale.x == pytest.approx(0.38)
    straight = {"shoulder": 0.0, "elbow": 0.0, "wrist": 0.0}
    (hand,) = robot.get_robot_markers(straight, ["hand"]).markers
    assert hand.pose.position.x == pytest.approx(1.03)
    assert len(robot.get_robot_markers("wrist_only", straight).markers) == 1
    state = RobotState(JointState(name=list(straight), position=list(straight.values())))
    assert robot.get_robot_markers(state).markers[3].pose == hand.pose
    with pytest.raises(MoveItCommanderException, match="cannot make sense of"):
        robot.get_robot_markers(3)
