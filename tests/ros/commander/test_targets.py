"""Every way to say where a group is to go, and what the planned motion does."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from trajopt.ros.commander.moveit_msgs.msg import RobotState
from trajopt.ros.commander.sensor_msgs.msg import JointState

import trajopt as to
from tests.ros.commander.conftest import SRDF, URDF
from tests.ros.commander.jumping import JumpingExecutor
from trajopt import placement
from trajopt.ros.commander import MoveGroupCommander, MoveItCommanderException, World
from trajopt.ros.commander.conversions import placement_of, pose_of, stamped
from trajopt.ros.commander.moveit.planning import MoveItPy
from trajopt.values.placement import Placement

WRIST = '<joint name="wrist"/>'
JOINTS = ("shoulder", "elbow", "wrist")
STATE = JointState(name=["elbow", "shoulder", "wrist"], position=[0.4, 0.1, -0.3])
GOAL = placement((0.6, 0.5, 0.1), rpy=(0.0, 0.0, 0.8))


@pytest.fixture
def arm(jumping: World) -> MoveGroupCommander:
    return MoveGroupCommander("arm", world=jumping)


def end_of(arm: MoveGroupCommander, world: World) -> dict[str, float]:
    success, trajectory, _, code = arm.plan()
    assert success, code.message
    points = trajectory.joint_trajectory
    assert points.joint_names == list(JOINTS)
    return dict(zip(JOINTS, points.points[-1].positions, strict=True))


def hand_at(world: World, joints: dict[str, float], link: str = "hand") -> Placement:
    return world.scene.placement_of(link, world.robot.positions(joints))


@pytest.mark.parametrize(
    "aim",
    [
        lambda arm: arm.set_joint_value_target([0.1, 0.4, -0.3]),
        lambda arm: arm.set_joint_value_target({"shoulder": 0.1, "elbow": 0.4, "wrist": -0.3}),
        lambda arm: arm.set_joint_value_target(STATE),
        lambda arm: arm.set_joint_value_target(RobotState(STATE)),
        lambda arm: (arm.remember_joint_values("there", [0.1, 0.4, -0.3]), arm.set_named_target("there")),
    ],
    ids=["list", "dictionary", "JointState", "RobotState", "remembered"],
)
def test_joint_values(arm: MoveGroupCommander, jumping: World, aim: Callable[..., None]) -> None:
    aim(arm)
    assert arm.get_joint_value_target() == [0.1, 0.4, -0.3]
    end = end_of(arm, jumping)
    assert np.allclose([end[joint] for joint in JOINTS], (0.1, 0.4, -0.3), atol=1e-4)


def test_one_joint_leaves_the_others(arm: MoveGroupCommander, jumping: World) -> None:
    arm.set_joint_value_target("elbow", 0.5)
    assert arm.get_joint_value_target() == [0.5, 0.5, 0.2]


def test_named_state(arm: MoveGroupCommander, jumping: World) -> None:
    assert arm.get_named_targets() == ["bent", "straight"]
    assert arm.get_named_target_values("bent") == {"shoulder": 0.5, "elbow": -1.0, "wrist": 0.2}
    arm.set_named_target("straight")
    assert np.allclose(list(end_of(arm, jumping).values()), 0.0, atol=1e-4)


@pytest.mark.parametrize(
    "aim",
    [
        lambda arm, pose: arm.set_pose_target(pose_of(pose)),
        lambda arm, pose: arm.set_pose_target(stamped(pose, "base")),
        lambda arm, pose: arm.set_pose_target([*pose.translation, *pose.rpy]),
        lambda arm, pose: arm.set_pose_target([*pose.translation, *pose.quaternion], "hand"),
        lambda arm, pose: arm.set_joint_value_target(pose_of(pose)),
        lambda arm, pose: arm.set_joint_value_target(stamped(pose, "world"), "hand", False),
    ],
    ids=["Pose", "PoseStamped", "six numbers", "seven numbers", "joint values of a Pose", "of a PoseStamped"],
)
def test_pose(arm: MoveGroupCommander, jumping: World, aim: Callable[..., None]) -> None:
    aim(arm, GOAL)
    reached = GOAL.inverse() * hand_at(jumping, end_of(arm, jumping))
    assert np.abs(reached.translation).max() < 1.1e-4
    assert np.abs(reached.rotation - np.eye(3)).max() < 1.1e-3


def test_pose_in_the_frame_of_a_moving_link_is_meant_where_it_is_now(
    arm: MoveGroupCommander, jumping: World
) -> None:
    now = hand_at(jumping, arm.get_named_target_values("bent"), "upper")
    arm.set_pose_reference_frame("upper")
    assert arm.get_pose_reference_frame() == "upper"
    arm.set_pose_target(pose_of(placement((0.6, 0.1, 0.0))))
    reached = hand_at(jumping, end_of(arm, jumping))
    assert np.allclose(reached.translation, (now * placement((0.6, 0.1, 0.0))).translation, atol=2e-4)


def test_position_and_orientation_alone(arm: MoveGroupCommander, jumping: World) -> None:
    arm.set_position_target([0.3, 0.6, 0.1])
    assert np.allclose(hand_at(jumping, end_of(arm, jumping)).translation, (0.3, 0.6, 0.1), atol=1.1e-4)
    quaternion = [0, 0, np.sin(0.55), np.cos(0.55)]
    for aim, turn in ((arm.set_rpy_target, [0, 0, 1.1]), (arm.set_orientation_target, quaternion)):
        aim(turn)
        assert abs(hand_at(jumping, end_of(arm, jumping)).rpy[2] - 1.1) < 1.1e-3


def test_several_poses_any_of_which_will_do(arm: MoveGroupCommander, jumping: World) -> None:
    beyond, within = placement((3.0, 0.0, 0.1)), GOAL
    arm.set_pose_targets([pose_of(beyond), pose_of(within)])
    assert np.allclose(hand_at(jumping, end_of(arm, jumping)).translation, within.translation, atol=2e-4)


def test_shift(arm: MoveGroupCommander, jumping: World) -> None:
    before = placement_of(arm.get_current_pose().pose)
    arm.shift_pose_target(1, 0.1)
    moved = hand_at(jumping, end_of(arm, jumping))
    assert np.allclose(moved.translation - before.translation, (0, 0.1, 0), atol=2e-4)
    assert np.allclose(moved.rotation, before.rotation, atol=2e-3)
    arm.shift_pose_target(5, 0.3)
    turned = hand_at(jumping, end_of(arm, jumping))
    assert np.allclose(turned.translation, before.translation, atol=2e-4)
    assert turned.rpy[2] - before.rpy[2] == pytest.approx(0.3, abs=2e-3)


def test_clearing_poses_leaves_the_joint_values(arm: MoveGroupCommander, jumping: World) -> None:
    arm.set_joint_value_target([0.1, 0.4, -0.3])
    arm.set_pose_target(pose_of(GOAL))
    arm.clear_pose_targets()
    assert np.allclose(list(end_of(arm, jumping).values()), (0.1, 0.4, -0.3), atol=1e-4)
    arm.set_pose_target(pose_of(GOAL))
    arm.clear_pose_target("hand")
    assert np.allclose(list(end_of(arm, jumping).values()), (0.1, 0.4, -0.3), atol=1e-4)


def test_random_values_are_within_limits_and_the_same_every_time(lab_arm: object) -> None:
    drawn: list[list[float]] = []
    for _ in range(2):
        arm = MoveGroupCommander("arm", world=World(lab_arm))
        arm.set_random_target()
        drawn.append([*arm.get_joint_value_target(), *arm.get_random_joint_values()])
        assert np.abs(drawn[-1]).max() <= 2.5
        assert arm.get_random_pose().header.frame_id == "base"
    assert drawn[0] == drawn[1]


@pytest.mark.parametrize("part", [0, 1, 2])
def test_tolerances_hold_along_each_axis_of_the_goal(
    arm: MoveGroupCommander, jumping: World, part: int
) -> None:
    """The hand cannot turn out of the plane: a goal above it is within reach along z alone."""
    tolerances = [1e-3] * 3
    tolerances[part] = 0.05
    offset = np.zeros(3)
    offset[2] = 0.04
    arm.set_goal_position_tolerance(tolerances)
    assert arm.get_goal_position_tolerance() == tolerances
    arm.set_pose_target(pose_of(placement(GOAL.translation + offset, rotation=GOAL.rotation)))
    success, _, _, code = arm.plan()
    assert success == (part == 2), code.message


def test_orientation_tolerance_about_each_axis(arm: MoveGroupCommander, jumping: World) -> None:
    tilted = placement(GOAL.translation, rotation=GOAL.rotation @ placement(rpy=(0.2, 0, 0)).rotation)
    for tolerances, possible in (([0.3, 0.01, 0.01], True), ([0.01, 0.3, 0.3], False)):
        arm.set_goal_orientation_tolerance(tolerances)
        arm.set_pose_target(pose_of(tilted))
        assert arm.plan()[0] == possible


def test_an_axis_left_free(arm: MoveGroupCommander, jumping: World) -> None:
    arm.set_goal_orientation_tolerance([0.01, 0.01, np.pi])
    arm.set_pose_target(pose_of(placement((0.2, 0.9, 0.1), rpy=(0, 0, -2.9))))
    assert np.allclose(hand_at(jumping, end_of(arm, jumping)).translation, (0.2, 0.9, 0.1), atol=2e-4)


def test_joint_tolerance(arm: MoveGroupCommander, jumping: World) -> None:
    arm.set_goal_joint_tolerance(0.02)
    arm.set_joint_value_target([0.1, 0.4, -0.3])
    (goal,) = arm.construct_motion_plan_request().goal_constraints
    assert {(item.tolerance_above, item.tolerance_below) for item in goal.joint_constraints} == {(0.02, 0.02)}


@pytest.mark.parametrize(
    ("misuse", "said"),
    [
        (lambda arm: arm.set_named_target("bend"), r"did you mean 'bent'\?\); there are: bent, straight"),
        (lambda arm: arm.set_joint_value_target("elbo", 0.1), "there are: elbow, shoulder, wrist"),
        (
            lambda arm: arm.set_joint_value_target("elbow", 2.6),
            r"to 149 deg \(2.6000 rad\): its limits are \[-143.2",
        ),
        (lambda arm: arm.set_joint_value_target([0.1, 0.2]), r"needs shape \(3,\), has \(2,\)"),
        (lambda arm: arm.set_joint_value_target([0.1, 0.2, 0.3], 1.0), "for a joint's name or a pose only"),
        (lambda arm: arm.set_joint_value_target([0.1, 0.2, np.nan]), "not finite"),
        (lambda arm: arm.set_pose_target([1, 2, 3]), "a pose is a Pose, a PoseStamped"),
        (
            lambda arm: arm.set_pose_target(pose_of(GOAL), "claw"),
            "there are: base, finger, fore, hand",
        ),
        (lambda arm: arm.set_pose_target(stamped(GOAL, "tabel")), "no frame named 'tabel'"),
        (lambda arm: arm.set_pose_targets([]), "at least one pose"),
        (lambda arm: arm.set_pose_targets(pose_of(placement())), "poses must be a list"),
        (lambda arm: arm.set_joint_value_target(pose_of(placement((3, 0, 0)))), "no configuration free of"),
        (lambda arm: arm.set_joint_value_target(pose_of(GOAL), True), "no approximate solutions"),
        (lambda arm: arm.shift_pose_target(6, 0.1), "axis must be 0 to 5"),
        (lambda arm: arm.forget_joint_values("never"), "there are: none"),
        (lambda arm: arm.remember_joint_values("x", [1.0]), r"needs shape \(3,\)"),
        (lambda arm: arm.set_goal_position_tolerance(-1.0), "is negative"),
        (lambda arm: arm.set_goal_position_tolerance([1.0, 2.0]), r"needs shape \(3,\)"),
    ],
)
def test_misuse_names_the_offender_and_changes_nothing(
    arm: MoveGroupCommander, misuse: Callable[..., None], said: str
) -> None:
    before = arm.construct_motion_plan_request()
    with pytest.raises(MoveItCommanderException, match=said):
        misuse(arm)
    assert arm.construct_motion_plan_request() == before


def test_no_end_effector(tmp_path: Path) -> None:
    (tmp_path / "lab.urdf").write_text(URDF)
    (tmp_path / "lab.srdf").write_text(SRDF.replace(WRIST, '<joint name="shoulder"/>' + WRIST))
    lab = to.load(tmp_path / "lab.urdf", srdf=tmp_path / "lab.srdf")
    with World(lab, executor=JumpingExecutor(lab.positions("bent"))) as world:
        apart = MoveGroupCommander("wrist_only", world=world)
        assert not apart.has_end_effector_link()
        with pytest.raises(MoveItCommanderException, match="is not a chain and has no end effector"):
            apart.get_current_pose()
        apart.set_end_effector_link("finger")
        assert apart.get_current_pose().pose.position.x > 0.0


def test_joints_in_a_row_are_a_chain_as_in_moveit(jumping: World) -> None:
    """Fetch's SRDF lists the joints of its arm, and its scripts ask for poses of its last link."""
    assert MoveGroupCommander("wrist_only", world=jumping).get_end_effector_link() == "hand"


def test_remembering(arm: MoveGroupCommander) -> None:
    arm.remember_joint_values("here")
    assert arm.get_remembered_joint_values() == {"here": [0.5, -1.0, 0.2]}
    assert "here" in arm.get_named_targets()
    arm.forget_joint_values("here")
    assert arm.get_remembered_joint_values() == {}


def test_a_hand_has_values_for_its_mimic_joints() -> None:
    """As in MoveIt, whose scripts set both fingers of a Panda."""
    with World("panda") as world:
        hand = MoveGroupCommander("hand")
        goal = hand.get_current_joint_values()
        assert len(goal) == hand.get_variable_count() == len(hand.get_random_joint_values()) == 2
        goal[0], goal[1] = 0.02, 0.02
        assert hand.go(goal) and np.allclose(hand.get_current_joint_values(), 0.02, atol=1e-4)
        hand.set_joint_value_target({"panda_finger_joint1": 0.03, "panda_finger_joint2": 0.03})
        assert np.allclose(hand.get_joint_value_target(), 0.03)
        hand.remember_joint_values("narrow", [0.01])
        assert hand.get_remembered_joint_values() == {"narrow": [0.01, 0.01]}
        assert hand.go([0.03]) and hand.go("narrow")
        hand.set_end_effector_link("panda_leftfinger")
        assert np.shape(hand.get_jacobian_matrix([0.01, 0.01])) == (6, 1)
        with pytest.raises(MoveItCommanderException, match=r"needs shape \(1,\), has \(3,\)"):
            hand.set_joint_value_target([0.01] * 3)
        state = MoveItPy(world=world).current_state()
        state.set_joint_group_positions("hand", [0.02, 0.02])
        state.set_joint_group_active_positions("hand", [0.025])
        assert state.get_joint_group_positions("hand").tolist() == [0.025, 0.025]


def test_random_values_of_rails_are_within_their_limits(tmp_path: Path) -> None:
    joint = (
        '<joint name="rail" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/>'
        '<limit lower="4" upper="9" effort="1" velocity="1"/></joint>'
    )
    (tmp_path / "rail.urdf").write_text(
        f'<robot name="rail"><link name="base"/><link name="cart"/>{joint}</robot>'
    )
    rail = MoveGroupCommander("all", world=World(to.load(tmp_path / "rail.urdf")))
    rail.set_random_target()
    assert 4.0 <= rail.get_joint_value_target()[0] <= 9.0
