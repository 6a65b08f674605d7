"""One form of configuration everywhere: starts, goals and placements take the same ones."""

from typing import Any

import numpy as np
import pytest

import trajopt as to
from trajopt.problem.requirements import FramePlacement, JointPositions
from trajopt.scene.group_tools import tool_of
from trajopt.values.errors import JointNotFound, PlanningFailed, ProblemError, ShapeError

ARM = tuple(f"panda_joint{n}" for n in range(1, 8))
TARGET = to.placement((0.4, 0.1, 0.5), rpy=(180, 0, 90), degrees=True)


@pytest.fixture(scope="module")
def panda() -> to.Scene:
    return to.Scene(to.load("panda"))


@pytest.fixture(scope="module")
def to_ready(panda: to.Scene) -> to.Result:
    return to.plan(to.Problem(scene=panda, group="panda_arm", start="extended", goal="ready"))


def forms(scene: to.Scene, planned: to.Result) -> dict[str, Any]:
    everything = scene.robot.positions("ready")
    arm = everything[scene.robot.index(ARM)]
    return {
        "state": "ready",
        "mapping": dict(zip(ARM, arm, strict=True)),
        "array of the group": arm,
        "list of the group": arm.tolist(),
        "array of all joints": everything,
        "list of all joints": everything.tolist(),
        "result": planned,
        "plan": planned.require(),
    }


def test_accepts_each_form_as_start_goal_and_in_placement_of(panda: to.Scene, to_ready: to.Result) -> None:
    ready = panda.robot.positions("ready")[panda.robot.index(ARM)]
    there = panda.placement_of("panda_hand", "ready")
    for name, form in forms(panda, to_ready).items():
        problem = to.Problem(scene=panda, group="panda_arm", start=form, goal=form)
        np.testing.assert_allclose(problem.reduced.start_positions, ready, atol=1e-6, err_msg=name)
        (goal,) = problem.goals
        assert isinstance(goal, JointPositions), name
        assert goal.positions == pytest.approx(dict(zip(ARM, ready, strict=True)), abs=1e-6), name
        found = panda.placement_of("panda_hand", form)
        np.testing.assert_allclose(found.homogeneous, there.homogeneous, atol=1e-6, err_msg=name)


def test_arrays_of_the_group_are_in_degrees_if_requested(panda: to.Scene) -> None:
    numbers = [0, -45, 0, -135, 0, 90, 45]
    problem = to.Problem(scene=panda, group="panda_arm", start=numbers, goal=numbers, degrees=True)
    np.testing.assert_allclose(problem.reduced.start_positions, np.deg2rad(numbers))
    (goal,) = problem.goals
    assert isinstance(goal, JointPositions)
    assert list(goal.positions.values()) == pytest.approx(list(np.deg2rad(numbers)))


def test_rejects_wrong_configurations_with_one_message(panda: to.Scene) -> None:
    def as_start(given: Any) -> object:
        return to.Problem(scene=panda, group="panda_arm", start=given, goal="ready")

    def as_placed(given: Any) -> object:
        return panda.placement_of("panda_hand", given)

    for call in (as_start, as_placed):
        with pytest.raises(ShapeError, match=r"has 5 numbers,.* and the robot has 9 joints"):
            call([0.0] * 5)
        with pytest.raises(JointNotFound, match="panda_joint9"):
            call({"panda_joint9": 0.1})
        with pytest.raises(
            ProblemError, match="must be the name of a state, joint -> position, positions of"
        ):
            call(to.Box(1.0, 1.0, 1.0))


def test_a_result_without_a_plan_is_not_a_configuration(panda: to.Scene) -> None:
    failed = to.plan(to.Problem(scene=panda, group="panda_arm", start="ready", goal={"panda_joint1": 9.0}))
    with pytest.raises(PlanningFailed):
        to.Problem(scene=panda, group="panda_arm", start=failed, goal="ready")


def test_the_end_of_a_plan_of_another_robot_names_its_joints(to_ready: to.Result) -> None:
    with pytest.raises(JointNotFound, match="panda_joint1"):
        to.Scene(to.load("ur5")).placement_of("world", to_ready)


def test_a_placement_is_of_the_tool_centre_point(panda: to.Scene) -> None:
    problem = to.Problem(scene=panda, group="panda_arm", start="ready", goal=TARGET)
    (goal,) = problem.goals
    assert isinstance(goal, FramePlacement) and goal.frame == "panda_hand_tcp"
    assert "panda_hand_tcp" in str(problem) and "panda_hand_tcp" in repr(problem)
    end = to.plan(problem).require()
    reached = panda.placement_of("panda_hand_tcp", end).translation
    np.testing.assert_allclose(reached, TARGET.translation, atol=1e-3)


def test_a_tool_of_the_scene_goes_before_the_tool_centre_point(panda: to.Scene) -> None:
    assert tool_of(panda.with_tool("driver", on="panda_hand"), "panda_arm") == "driver"


def test_a_group_with_its_fingers_ends_at_the_tool_centre_point(panda: to.Scene) -> None:
    assert tool_of(panda, "panda_arm_hand") == "panda_hand_tcp"


def test_two_end_effectors_have_no_single_tool(panda: to.Scene) -> None:
    with pytest.raises(ProblemError, match="no single tool frame"):
        tool_of(to.Scene(to.load("two_pandas")), "both")
