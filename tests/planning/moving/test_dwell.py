"""Planning to stay at the goal after the end."""

import numpy as np
import pytest

import trajopt as to
from tests.planning.moving.test_dynamic_search import GOAL, START
from tests.verify.test_moving_things import sampled
from trajopt.timing.time_scaling import begun_later


@pytest.fixture(scope="module")
def cell() -> to.Scene:
    try:
        return to.Scene(to.load("panda"))
    except to.MissingExtra as error:
        pytest.skip(str(error))


def occupied(scene: to.Scene, *, free: tuple[float, float]) -> to.Scene:
    """Return the scene with something where the hand is at the goal, but for a time."""
    there = to.placement(scene.placement_of("panda_hand", scene.robot.positions(GOAL)).translation)
    return scene.add("before", to.Sphere(0.05), there, expires=free[0]).add(
        "after", to.Sphere(0.05), there, appears=free[1]
    )


def problem(scene: to.Scene, dwell: float) -> to.Problem:
    return to.Problem(scene=scene, group="panda_arm", start=START, goal=to.joint_positions(GOAL), dwell=dwell)


def test_a_briefly_free_goal_does_not_allow_a_dwell(cell: to.Scene) -> None:
    result = to.plan(problem(occupied(cell, free=(1.5, 1.6)), 1.0))
    assert not result.verified and result.status is to.Status.GOAL_OCCUPIED
    assert "never free for 1 s" in result.reason
    scene = occupied(cell, free=(1.5, 1.9))
    passed = to.plan(problem(scene, 0.0)).require().trajectory
    assert 1.5 <= passed.duration <= 1.9
    staying = problem(scene, 1.0)
    assert sampled(scene, staying.reduced, passed) > 0.0
    certificate = to.judge(staying, passed)
    assert not certificate.verified and "after the end" in certificate.failed[0].detail
    assert to.plan(staying).status is to.Status.GOAL_OCCUPIED


def test_a_goal_that_is_free_for_long_enough_is_stayed_at(cell: to.Scene) -> None:
    scene = occupied(cell, free=(1.5, 3.0))
    result = to.plan(problem(scene, 1.0))
    motion = result.require().trajectory
    assert 1.5 <= motion.duration <= 2.0
    stayed = to.Trajectory(
        motion.joint_names, np.append(motion.times, motion.duration + 1.0),
        np.concatenate((motion.positions, motion.positions[-1:])),
    )  # fmt: skip
    assert sampled(scene, result.problem.reduced, stayed) > 0.0
    late = begun_later(motion, 0.7)
    assert not to.judge(result.problem, late).verified
