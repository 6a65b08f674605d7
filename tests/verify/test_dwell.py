"""What is proven of the time after the end: that the robot stays clear where it is."""

from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from tests.verify.test_moving_things import alone, clearance_of, swing
from trajopt.scene.reducing import reduce_model
from trajopt.scene.track import Prediction, Track
from trajopt.values.errors import ProblemError, ShapeError
from trajopt.verify import Judge, Specification
from trajopt.verify.certificate import Certificate, CheckKind

DURATION = 1.5
"""Of the motion that is judged [s]."""


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    return odd_arm(tmp_path_factory.mktemp("robot"))


def judged(scene: to.Scene, dwell: float) -> Certificate:
    reduced = reduce_model(scene, "all", np.zeros(len(scene.robot.joint_names)))
    judge, motion = Judge(reduced), swing(reduced, np.random.default_rng(0))
    asked = Specification(goals=(), dwell=dwell)
    certificate = judge.certify(motion, asked)
    assert judge.decide(motion, asked).verified == certificate.verified
    return certificate


@pytest.mark.parametrize(
    ("appears", "dwell", "holds"),
    [(1.6, 0.0, True), (1.6, 0.05, True), (1.6, 0.2, False), (1.45, 0.0, False)],
)
def test_an_obstacle_that_appears_at_the_goal_counts_during_the_dwell(
    arm: to.Robot, appears: float, dwell: float, holds: bool
) -> None:
    scene = alone(arm).add("block", to.Box(4.0, 4.0, 4.0), appears=appears)
    check = clearance_of(judged(scene, dwell))
    assert check.holds is holds
    if dwell and not holds:
        assert "block" in check.detail and "s after the end" in check.detail
        assert check.time is not None and appears - 1e-6 <= check.time <= DURATION + dwell


def test_obstacles_during_the_dwell_are_proven_clear_or_refused(arm: to.Robot) -> None:
    reduced = reduce_model(alone(arm), "all", np.zeros(len(arm.joint_names)))
    end = reduced.all_positions(swing(reduced, np.random.default_rng(0)).positions[-1])
    near = to.placement(reduced.scene.placement_of("tip", end).translation)
    far = to.placement(near.translation + np.array((0.0, 4.0, 0.0)))
    comes = Track.through([DURATION, DURATION + 1.0], [far, near])
    scene = alone(arm).add("box", to.Box(0.2, 0.2, 2.0), motion=comes)
    clearances = [judged(scene, dwell) for dwell in (0.0, 0.2, 0.4, 1.0)]
    values = [clearance_of(each).value for each in clearances]
    assert [clearance_of(each).holds for each in clearances] == [True, True, True, False]
    assert all(value is not None for value in values)


def test_a_prediction_has_to_last_as_long_as_the_robot_stays(arm: to.Robot) -> None:
    still = Track.constant_velocity(to.placement((9.0, 0.0, 0.0)), (0.0, 0.0, 0.0))
    scene = alone(arm).add("box", to.Box(0.1, 0.1, 0.1), motion=Prediction(still, until=2.0))
    for dwell, holds in ((0.4, True), (0.6, False)):
        (check,) = (c for c in judged(scene, dwell).checks if c.kind is CheckKind.PREDICTION)
        assert check.holds is holds
    assert check.detail == "the prediction of box ends at 2 s, but is needed until 2.100 s"


def test_contact_that_is_meant_at_the_end_is_meant_while_the_robot_stays(arm: to.Robot) -> None:
    reduced = reduce_model(alone(arm), "all", np.zeros(len(arm.joint_names)))
    motion = swing(reduced, np.random.default_rng(0))
    end = reduced.all_positions(motion.positions[-1])
    there = reduced.scene.placement_of(arm.links[-1], end)
    touching = alone(arm).add("part", to.Sphere(0.03), there, appears=DURATION - 0.01)
    for link in arm.links[:-1]:
        touching = touching.allow("part", link)
    meant = touching.allow_contact("press", "part", arm.links[-1], depth=0.2, last=0.02)
    for dwell in (0.0, 0.5):
        assert not clearance_of(judged(touching, dwell)).holds
        assert clearance_of(judged(meant, dwell)).holds


def test_a_dwell_in_a_static_scene_needs_no_further_proof(arm: to.Robot) -> None:
    scene = alone(arm).add("box", to.Box(0.1, 0.1, 0.1), to.placement((3.0, 0.0, 0.0)))
    one, other = judged(scene, 0.0), judged(scene, 5.0)
    assert one.clearance == other.clearance and one.verified == other.verified


def test_a_dwell_that_is_none_is_refused(arm: to.Robot) -> None:
    problem = to.Problem(scene=to.Scene(arm), start={"pan": 0.0}, goal={"pan": 0.1})
    assert problem.dwell == 0.0 and "stays" not in str(problem)
    assert "stays        1.5 s at the goal" in str(replace(problem, dwell=1.5))
    with pytest.raises(ProblemError, match="dwell must not be negative, is -1 s"):
        replace(problem, dwell=-1.0)
    with pytest.raises(ShapeError, match="dwell"):
        replace(problem, dwell=float("nan"))


def test_contact_during_the_dwell_is_not_the_robots_fault(arm: to.Robot) -> None:
    scene = alone(arm).add("block", to.Box(4.0, 4.0, 4.0), appears=1.6)
    certificate = judged(scene, 0.5)
    assert not certificate.verified and certificate.at_fault > 0.0
