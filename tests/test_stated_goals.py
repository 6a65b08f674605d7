"""Starts, goals and waypoints in all their forms: names of states, joints, placements, degrees."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.optimise.kinematics import inverse_kinematics
from trajopt.problem.requirements import FramePlacement, JointPositions
from trajopt.values.errors import JointNotFound, ProblemError, ShapeError, StateNotFound

AT = to.placement((0.4, 0.1, 0.5), rpy=(180, 0, 90), degrees=True)
READY = {
    f"panda_joint{n}": q
    for n, q in zip(range(1, 8), (0, -0.785398, 0, -2.35619, 0, 1.5708, 0.785398), strict=True)
}


@pytest.fixture(scope="module")
def panda() -> to.Scene:
    return to.Scene(to.load("panda"))


@pytest.fixture(scope="module")
def odd(tmp_path_factory: pytest.TempPathFactory) -> to.Scene:
    return to.Scene(odd_arm(tmp_path_factory.mktemp("odd")))


def problem(scene: to.Scene, **fields: Any) -> to.Problem:
    given = {"group": "panda_arm", "start": "ready", "goal": "ready"} if "panda" in scene.robot.name else {}
    return to.Problem(**{"scene": scene, **given, **fields})


def goal_of(scene: to.Scene, goal: Any, **fields: Any) -> Any:
    (only,) = problem(scene, goal=goal, **fields).goals
    return only


def test_a_state_is_a_goal_as_it_is_a_start(panda: to.Scene) -> None:
    named = goal_of(panda, "ready")
    assert isinstance(named, JointPositions)
    assert named.positions == pytest.approx(READY, abs=1e-5)
    assert goal_of(panda, "ready", group="panda_manipulator").positions == named.positions
    to.plan(problem(panda, start="extended", goal="ready")).require()


def test_a_state_of_other_joints_is_not_a_goal(panda: to.Scene) -> None:
    with pytest.raises(StateNotFound, match=r"no state of group 'panda_arm' named 'open'; known: extended, "):
        problem(panda, goal="open")
    both = to.Scene(to.load("two_pandas"))
    with pytest.raises(StateNotFound, match=r"of group 'both' named 'left_ready'; did you mean 'ready'"):
        to.Problem(scene=both, group="both", start="ready", goal="left_ready")


@pytest.mark.parametrize("field", ["start", "goal", "waypoints", "start_velocity"])
def test_a_joint_without_a_number_is_refused(panda: to.Scene, field: str) -> None:
    missing = {"panda_joint2": None}
    given = [missing] if field == "waypoints" else missing
    with pytest.raises(ShapeError, match=r"of panda_joint2: must be a number, is None"):
        problem(panda, **{field: given})


def test_any_goal_of_a_set_has_the_forms_of_a_goal(panda: to.Scene) -> None:
    forms = {
        "home": "ready",
        "above": AT,
        "bent": {"panda_joint4": -90.0},
        "both": ["ready", to.gravity_torque(0.9)],
    }
    asked = problem(panda, goal=to.any_of(forms), degrees=True)
    above = to.frame_placement("panda_hand_tcp", AT)
    assert str(asked.alternatives["above"].goals[0]) == str(above)
    (bent,) = asked.alternatives["bent"].goals
    assert isinstance(bent, JointPositions) and bent.positions["panda_joint4"] == pytest.approx(-np.pi / 2)
    assert [len(alone.goals) for alone in asked.alternatives.values()] == [1, 1, 1, 2]
    assert replace(asked, dwell=1.0).alternatives["bent"].goals == (bent,)
    result = to.plan(problem(panda, start="extended", goal=to.any_of({"home": "ready", "above": AT})))
    assert result.verified and result.goal_name in ("home", "above")


@pytest.mark.parametrize("wrong", [0.4, [0.1, 0.2], to.Box(1.0, 1.0, 1.0)])
def test_a_goal_of_a_set_in_none_of_the_forms_is_named(panda: to.Scene, wrong: Any) -> None:
    with pytest.raises(
        ProblemError, match="goal 'shelf' must be a requirement or several, the name of a state"
    ):
        problem(panda, goal=to.any_of({"shelf": wrong}))
    with pytest.raises(StateNotFound, match="did you mean 'ready'"):
        problem(panda, goal=to.any_of({"shelf": "redy"}))


def test_joints_by_name_are_a_goal(panda: to.Scene) -> None:
    assert goal_of(panda, {"panda_joint1": 0.3}).positions == {"panda_joint1": 0.3}
    with pytest.raises(JointNotFound):
        problem(panda, goal={"panda_joint9": 0.3})


@pytest.mark.parametrize(
    "form",
    [
        AT,
        pin.SE3(AT.rotation, AT.translation),
        AT.homogeneous,
        AT.homogeneous.tolist(),
        (AT.translation, AT.quaternion),
        [AT],
        (AT.homogeneous,),
    ],
    ids=["placement", "SE3", "matrix", "nested lists", "pair", "list of one", "tuple of one matrix"],
)
def test_a_placement_is_where_the_tool_must_be(panda: to.Scene, form: Any) -> None:
    asked = goal_of(panda, form)
    assert isinstance(asked, FramePlacement)
    assert asked.frame == "panda_hand_tcp" and asked.reference == "world"
    np.testing.assert_allclose(asked.placement.homogeneous, AT.homogeneous, atol=1e-9)
    assert goal_of(panda, form, group="panda_manipulator").frame == "panda_hand_tcp"


def test_forms_are_mixed_and_are_waypoints_too(panda: to.Scene) -> None:
    mixed = problem(
        panda, goal=[AT, to.gravity_torque(0.9)], waypoints=["extended", [AT, {"panda_joint1": 0.1}]]
    )
    assert [type(item).__name__ for item in mixed.goals] == ["FramePlacement", "GravityTorque"]
    assert [len(each) for each in mixed.waypoint_requirements] == [1, 2]
    assert mixed.waypoint_names == ("1", "2")
    again = replace(mixed, knots=30)
    assert again.goals == mixed.goals and again.waypoint_requirements == mixed.waypoint_requirements


def test_the_tool_is_the_one_that_the_robot_was_given(odd: to.Scene, tmp_path: Path) -> None:
    assert goal_of(odd, AT, start={}).frame == "finger"  # the last of the group of all joints
    path = Path(odd.robot.urdf_path)
    one = to.Scene(to.Robot.from_urdf(path, frames={"tcp": ("finger", to.placement((0, 0, 0.05)))}))
    assert goal_of(one, AT, start={}).frame == "tcp"
    assert goal_of(one.with_tool("gun", on="tcp"), AT, start={}).frame == "gun"
    assert goal_of(one.with_tool("base_camera", on="base"), AT, start={}).frame == "tcp"
    aside = one.add("stand", to.Sphere(0.1)).with_tool("marker", on="stand")
    assert goal_of(aside, AT, start={}).frame == "tcp"
    frames = {"tcp": ("finger", AT), "camera": ("finger", AT)}
    with pytest.raises(ProblemError, match=r"no single tool frame .* frame_placement.* tcp, camera"):
        problem(to.Scene(to.Robot.from_urdf(path, frames=frames)), start={}, goal=AT)


def test_where_no_frame_is_the_tool_the_ends_are_named() -> None:
    both = to.Scene(to.load("two_pandas"))
    with pytest.raises(
        ProblemError, match=r"'both' has no single tool.* left_panda_link8, right_panda_link8"
    ):
        to.Problem(scene=both, group="both", start="ready", goal=AT)


@pytest.mark.parametrize("goal", [None, 3, [0.1] * 8, (0.4, 0.0, 0.3), np.zeros(8), object(), [AT, 3.0]])
def test_invalid_goals_are_refused_in_words(panda: to.Scene, goal: Any) -> None:
    with pytest.raises(ProblemError, match=r"^goal must be a requirement or several, the name of a state"):
        problem(panda, goal=goal)


def test_start_uses_the_named_state_of_its_own_group(tmp_path: Path) -> None:
    """Each group that `trajopt srdf` proposes has a state "home"; that of the first was all that counted."""
    home = '<group_state name="home" group="{0}">{1}</group_state>'
    first = '<joint name="elbow" value="0.1"/><joint name="pan" value="0.4"/>'
    second = '<joint name="elbow" value="0.2"/>'
    (tmp_path / "odd.srdf").write_text(
        '<robot name="odd"><group name="turret"><joint name="pan"/><joint name="elbow"/></group>'
        '<group name="arm"><joint name="elbow"/><joint name="wrist"/></group>'
        f"{home.format('turret', first)}{home.format('arm', second)}</robot>"
    )
    robot = to.load(odd_arm(tmp_path).urdf_path, srdf=tmp_path / "odd.srdf")
    for group, elbow in (("turret", 0.1), ("arm", 0.2)):
        asked = to.Problem(scene=to.Scene(robot), group=group, start="home", goal="home")
        at = dict(zip(robot.joint_names, asked.start_positions.tolist(), strict=True))
        assert (at["pan"], at["elbow"], at["wrist"]) == (0.4, elbow, 0.0)


def test_two_states_as_one_goal_suggest_any_of(panda: to.Scene) -> None:
    result = to.plan(problem(panda, goal=["ready", "extended"]))
    assert result.status is to.Status.CONFLICTING_CONSTRAINTS
    assert "panda_joint2 are 44.99 deg farther apart than" in result.message
    assert result.message.endswith("; any_of takes either of several goals")


def test_missing_numbers_of_a_start_are_named(panda: to.Scene, odd: to.Scene) -> None:
    with pytest.raises(
        ShapeError, match=r"has 8 numbers.*those that follow no other, panda_finger_joint2 is"
    ):
        problem(panda, start=[0.0] * 8)
    with pytest.raises(
        ShapeError,
        match=r"has 5 numbers, group panda_arm has 7 joints, and the robot has 9 joints: panda_joint1",
    ):
        problem(panda, start=np.zeros(5))
    with pytest.raises(
        ShapeError, match=r"3 numbers, group all has 4 joints, and the robot has 5 joints: pan, .*follow"
    ):
        problem(odd, start=(0.0,) * 3, goal={"pan": 1.0})
    with pytest.raises(
        ProblemError, match=r"^start must be the name of a state, joint -> position, positions of "
    ):
        problem(panda, start=None)


def test_degrees_are_taken_where_joints_turn(odd: to.Scene) -> None:
    asked = {"elbow": 30.0, "reach": 0.1}
    stated = problem(
        odd, start=asked, goal={"elbow": 60.0, "reach": 0.2}, waypoints=[{"wrist": 45.0}],
        start_velocity={"elbow": 10.0, "reach": 0.05}, start_acceleration={"wrist": 20.0}, degrees=True,
    )  # fmt: skip
    index = odd.robot.index(("elbow", "reach"))
    np.testing.assert_allclose(stated.start_positions[index], (np.pi / 6, 0.1))
    np.testing.assert_allclose(odd.robot.positions(asked, degrees=True)[index], (np.pi / 6, 0.1))
    (goal,) = stated.goals
    assert isinstance(goal, JointPositions)
    assert goal.positions == pytest.approx({"elbow": np.pi / 3, "reach": 0.2})
    ((via,),) = stated.waypoint_requirements
    assert isinstance(via, JointPositions) and via.positions == pytest.approx({"wrist": np.pi / 4})
    assert stated.start_velocity == pytest.approx({"elbow": np.deg2rad(10.0), "reach": 0.05})
    assert stated.start_acceleration == pytest.approx({"wrist": np.deg2rad(20.0)})
    again = replace(stated, knots=30)
    np.testing.assert_array_equal(again.start_positions, stated.start_positions)
    assert again.goals == stated.goals and again.start_velocity == stated.start_velocity
    array = problem(odd, start=np.array((90.0, 0.1, 30.0, 0.0, 11.459155902616464)), goal=asked, degrees=True)
    np.testing.assert_allclose(array.start_positions[:3], (np.pi / 2, 0.1, np.pi / 6))


def test_joint_positions_are_taken_in_degrees_where_all_turn(odd: to.Scene) -> None:
    asked = to.joint_positions({"elbow": 30.0}, tolerance=2.0, above={"elbow": 3.0}, degrees=True)
    sides = (asked.positions, asked.below, asked.above)
    assert [side["elbow"] for side in sides] == pytest.approx(np.deg2rad((30.0, 2.0, 3.0)))
    assert to.joint_positions({"elbow": 30.0}, degrees=True).below == {"elbow": 1e-4}
    slides = to.joint_positions({"elbow": 30.0, "reach": 0.1}, degrees=True)
    with pytest.raises(ProblemError, match=r"position of reach is in degrees, but the joint is prismatic"):
        problem(odd, start={}, goal=slides)
    reduced = problem(odd, start={}, goal={"elbow": 0.1}).reduced
    with pytest.raises(ProblemError, match=r"position of reach is in degrees"):
        inverse_kinematics(reduced, slides, rng=np.random.default_rng(0))


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ({"goal": {}}, "goal"),
        ({"goal": [{}]}, "goal"),
        ({"goal": "ready", "waypoints": [{}]}, "waypoint '1'"),
    ],
)
def test_names_the_argument_without_a_joint(panda: to.Scene, given: dict[str, Any], name: str) -> None:
    with pytest.raises(ProblemError, match=f"^{name}: name at least one joint"):
        to.Problem(scene=panda, group="panda_arm", start="ready", **given)
