"""What is asked for by hand: goals of the hand and of joints, and why the robot cannot stand there."""

import numpy as np
import pytest

import trajopt as to
from tests.viewer.conftest import Motion
from trajopt.values.errors import GroupNotFound, ProblemError
from trajopt.viewer.live.panels import short
from trajopt.viewer.live.workbench import Reachability, Workbench


@pytest.fixture
def bench() -> Workbench:
    scene = to.Scene(to.load("panda")).add("post", to.Box(0.1, 0.1, 0.8), to.placement((0.5, 0.3, 0.4)))
    return Workbench(scene)


def moved(bench: Workbench, by: tuple[float, float, float]) -> to.Placement:
    now = bench.placement_of(bench.hand)
    return to.placement(now.translation + np.array(by), quaternion=now.quaternion)


def test_the_robot_begins_at_its_goal(bench: Workbench) -> None:
    assert bench.group == "panda_arm" and bench.hand == "panda_hand_tcp"
    np.testing.assert_allclose(bench.goal.positions, bench.positions)
    assert bench.at_goal and "drag the arrows" in bench.refusal


def test_a_goal_in_reach_places_the_hand_as_requested(bench: Workbench) -> None:
    asked = moved(bench, (0.1, -0.2, -0.1))
    bench.move_hand(asked)
    assert bench.goal.reachability is Reachability.REACHABLE and not bench.refusal
    there = bench.scene.placement_of(bench.hand, bench.reduced.all_positions(bench.goal.positions))
    np.testing.assert_allclose(there.homogeneous, asked.homogeneous, atol=2e-3)
    assert "Nearest: panda_" in bench.goal.words and " from post" in bench.goal.words
    assert to.plan(bench.problem).verified


def test_the_posture_follows_a_drag_without_a_jump(bench: Workbench) -> None:
    for step in range(1, 21):
        before = bench.goal.positions
        bench.move_hand(moved(bench, (0.0, -0.01 * step, -0.005 * step)))
        assert np.abs(bench.goal.positions - before).max() < 0.3, step


def test_a_colliding_goal_names_the_obstacle(bench: Workbench) -> None:
    bench.move_hand(to.placement((0.5, 0.3, 0.4), rpy=(3.1416, 0.0, 0.0)))
    assert bench.goal.reachability is Reachability.COLLIDING
    assert bench.goal.words.startswith("In collision: ") and "post" in bench.goal.words
    assert bench.refusal == "the goal is in collision"


def test_an_unreachable_goal_reports_its_distance(bench: Workbench) -> None:
    bench.move_hand(moved(bench, (2.0, 0.0, 0.0)))
    assert bench.goal.reachability is Reachability.OUT_OF_REACH
    assert "no nearer than 1." in bench.goal.words and " m" in bench.goal.words


def test_a_goal_that_limits_forbid_names_the_joint() -> None:
    robot = to.load("panda")
    bench = Workbench(to.Scene(robot))
    turned = np.array(bench.positions)
    turned[5] = robot.limits.upper[robot.index(["panda_joint6"])][0] + 0.35
    beyond = bench.scene.placement_of(bench.hand, bench.reduced.all_positions(turned))
    bench.move_hand(beyond)
    if bench.goal.reachability is not Reachability.REACHABLE:
        assert bench.goal.reachability is Reachability.BEYOND_LIMITS, bench.goal.words
    bench.move_joints(turned)
    assert bench.goal.reachability is Reachability.BEYOND_LIMITS
    assert "panda_joint6" in bench.goal.words and "beyond its joints' limits" in bench.refusal


def test_a_joint_alone_moves_and_the_hand_goes_along(bench: Workbench) -> None:
    bench.move_joint("panda_joint1", 0.5)
    assert bench.goal.positions[0] == 0.5
    np.testing.assert_allclose(bench.goal.positions[1:], bench.positions[1:])
    there = bench.scene.placement_of(bench.hand, bench.reduced.all_positions(bench.goal.positions))
    np.testing.assert_allclose(bench.goal.placement.homogeneous, there.homogeneous)


def test_named_states_are_goals(bench: Workbench) -> None:
    assert set(bench.states) == {"ready", "extended", "transport"}
    bench.move_joints(bench.states["transport"])
    assert bench.goal.reachability is Reachability.REACHABLE
    bench.reset_goal()
    assert bench.at_goal


def test_an_arm_of_few_joints_gets_position_goals(motion: Motion) -> None:
    robot = motion.reduced.scene.robot
    bench = Workbench(to.Scene(robot), start={"slide": 0.12, "turn": -0.8, "wrist": 0.0})
    assert not bench.turned
    bench.move_hand(moved(bench, (0.0, 0.0, 0.1)))
    assert bench.goal.reachability is Reachability.REACHABLE
    np.testing.assert_allclose(bench.goal.positions[:2], (0.22, -0.8), atol=1e-3)
    bench.count_orientation(True)
    assert bench.goal.reachability is Reachability.REACHABLE  # it is not turned


def test_adding_an_object_checks_the_goal_again(bench: Workbench) -> None:
    bench.move_hand(moved(bench, (0.1, -0.2, -0.1)))
    goal = bench.goal.placement
    bench.change(bench.scene.add("crate", to.Box(0.5, 0.5, 0.5), to.placement(goal.translation)))
    assert bench.goal.reachability is Reachability.COLLIDING and "crate" in bench.goal.words


def test_invalid_groups_are_refused() -> None:
    scene = to.Scene(to.load("panda"))
    with pytest.raises(GroupNotFound, match="panda_arm"):
        Workbench(scene, "panda_amr")
    with pytest.raises(ProblemError, match="start"):
        Workbench(scene, start=3.0)  # pyright: ignore


def test_labels_omit_the_common_prefix() -> None:
    assert short("panda_joint1", ("panda_joint1", "panda_joint2")) == "joint1"
    assert short("shoulder_pan_joint", ("shoulder_pan_joint", "shoulder_lift_joint")) == "pan_joint"
    assert short("a/b_c", ("a/b_c", "d")) == "a/b_c"
    assert short("arm_turn", ("arm_turn",)) == "arm_turn"
