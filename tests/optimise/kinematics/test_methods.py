"""Methods of inverse kinematics: solutions hold the goal by an independent check, or a refusal names it."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from tests.robot.test_mimics import planar
from trajopt.optimise.kinematics import INVERSE_METHODS, inverse_kinematics, validity
from trajopt.optimise.kinematics.projection import Projection
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.arrays import Floats
from trajopt.values.errors import RequirementNotSupported, SolverNotFound

METHODS = tuple(INVERSE_METHODS)


def model_of(name: str, group: str) -> ReducedModel:
    try:
        robot = to.load(name)
    except to.MissingExtra as error:
        pytest.skip(str(error))
    return reduce_model(to.Scene(robot), group, robot.positions())


def placed(reduced: ReducedModel, q: Floats, frame: str) -> pin.SE3:
    """Place a link with pinocchio and the robot's whole model, which no method is given."""
    robot = reduced.scene.robot
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.configuration(reduced.all_positions(q)))
    return data.oMf[robot.model.getFrameId(frame, pin.FrameType.BODY)]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("robot", "group", "tip"),
    [("panda", "panda_arm", "panda_hand"), ("ur5", "manipulator", "tool0"), ("planar2", "arm", "")],
)
def test_solutions_hold_the_goal(robot: str, group: str, tip: str, method: str) -> None:
    if robot == "planar2":
        arm = to.load(robot)
        group, tip = next(iter(arm.groups)), arm.links[-1]
    reduced = model_of(robot, group)
    rng, limits = np.random.default_rng(3), reduced.limits
    for _ in range(4):
        inside = rng.uniform(np.maximum(limits.lower, -3.0), np.minimum(limits.upper, 3.0))
        want = placed(reduced, inside, tip)
        goal = to.frame_placement(tip, to.placement(want.translation, rotation=want.rotation))
        found = inverse_kinematics(reduced, goal, method=method, starts=32)
        solutions = (*found.free, *found.colliding)
        assert solutions, found.explain()
        for q in solutions:
            assert (q >= limits.lower).all() and (q <= limits.upper).all()
            off = want.actInv(placed(reduced, q, tip))
            assert np.abs(off.translation).max() <= 1e-4 + 1e-9
            assert np.abs(pin.log3(off.rotation)).max() <= 1e-3 + 1e-9


@pytest.mark.parametrize("method", METHODS)
def test_joints_outside_the_group_stay(pair: ReducedModel, method: str) -> None:
    robot = pair.scene.robot
    start = robot.positions({"right_shoulder": 0.7, "right_elbow": -0.4})
    left = reduce_model(to.Scene(robot), "left", start)
    want = placed(left, np.array([0.5, -0.6]), "left_hand")
    goal = to.frame_placement("left_hand", to.placement(want.translation, rotation=want.rotation))
    found = inverse_kinematics(left, goal, method=method)
    assert found.free
    for q in found.free:
        everything = dict(zip(robot.joint_names, left.all_positions(q).tolist(), strict=True))
        assert (everything["right_shoulder"], everything["right_elbow"]) == (0.7, -0.4)
        assert np.allclose(placed(left, q, "left_hand").translation, want.translation, atol=2e-4)


@pytest.mark.parametrize("method", METHODS)
def test_mimic_joints_follow(tmp_path: Path, method: str) -> None:
    arm = planar(tmp_path, {"m1": ("j1", -0.5, 0.3)})
    reduced = reduce_model(to.Scene(arm), next(iter(arm.groups)), arm.positions())
    tip = arm.links[-1]
    want = placed(reduced, np.array([0.9, -0.7]), tip)
    goal = to.frame_placement(
        tip, to.placement(want.translation, rotation=want.rotation), rotation_tolerance=np.inf
    )
    found = inverse_kinematics(reduced, goal, method=method)
    assert found.free or found.colliding
    for q in (*found.free, *found.colliding):
        assert np.abs(placed(reduced, q, tip).translation - want.translation).max() <= 1e-4 + 1e-9


@pytest.mark.parametrize("method", METHODS)
def test_tolerances_free_axes_and_several_requirements(odd: ReducedModel, method: str) -> None:
    where = odd.scene.placement_of("ball", odd.all_positions(np.array([-0.8, 0.2, -0.3, 0.5])))
    goals = [
        to.frame_placement("ball", where, position_tolerance=(1e-3, 1e-3, np.inf), rotation_tolerance=np.inf),
        to.joint_positions({odd.joint_names[3]: 0.5}, tolerance=0.2),
    ]
    found = inverse_kinematics(odd, goals, method=method)
    assert found.free or found.colliding, found.explain()
    for q in (*found.free, *found.colliding):
        seen = where.inverse() * odd.scene.placement_of("ball", odd.all_positions(q)).translation
        assert np.abs(seen[:2]).max() <= 1e-3 and abs(q[3] - 0.5) <= 0.2 + 1e-9


@pytest.mark.parametrize("method", METHODS)
def test_an_axis_points_along_a_direction(panda: ReducedModel, method: str) -> None:
    goals = [
        to.axis_alignment("panda_hand", direction=(0.0, 0.6, -0.8), tolerance=0.02),
        to.frame_placement("panda_hand", to.placement((0.4, 0.2, 0.4)), rotation_tolerance=np.inf),
    ]
    found = inverse_kinematics(panda, goals, method=method)
    assert found.free
    for q in found.free:
        at = placed(panda, q, "panda_hand")
        assert at.rotation[:, 2] @ (0.0, 0.6, -0.8) >= np.cos(0.02) - 1e-9
        assert np.abs(at.translation - (0.4, 0.2, 0.4)).max() <= 1e-4 + 1e-9
        assert validity(panda, q, requirements=goals).valid


def test_requirements_unknown_to_placo_are_refused_by_name(panda: ReducedModel) -> None:
    goal = to.coupled_joints({"panda_joint1": 1.0, "panda_joint2": 1.0}, tolerance=0.01)
    with pytest.raises(RequirementNotSupported, match="there is no task for CoupledJoints") as refused:
        inverse_kinematics(panda, goal, method="placo")
    assert refused.value.requirement is goal
    assert inverse_kinematics(panda, goal).free


def test_an_unknown_method_is_refused_with_near_matches(panda: ReducedModel) -> None:
    with pytest.raises(SolverNotFound, match="placo"):
        inverse_kinematics(panda, to.joint_positions({"panda_joint1": 0.1}), method="plako")


class Liar:
    """A method that goes nowhere near the goal, and beyond all limits."""

    name = "liar"

    def search(self, projection: Projection) -> Callable[[Floats], Floats]:
        return lambda begin: begin + 100.0


def test_a_method_is_not_trusted(panda: ReducedModel) -> None:
    goal = to.frame_placement("panda_hand", to.placement((0.4, 0.2, 0.4)))
    found: Sequence[Floats] = inverse_kinematics(panda, goal, method=Liar()).free
    assert not found
