"""Paths that a caller gives are tried first, and moved to where the problem begins and ends."""

from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from trajopt.planning.seeds import SeedKind
from trajopt.problem.problem import named_problem
from trajopt.values.errors import JointNotFound, ProblemError, ShapeError
from trajopt.values.trajectory import Path


@pytest.fixture(scope="module")
def solved() -> to.Result:
    result = to.plan(named_problem("narrow_mouth_ur5"))
    assert result.verified
    return result


def test_a_given_path_is_tried_first_and_saves_work(solved: to.Result) -> None:
    path = solved.require().path
    again = to.plan(solved.problem, seeds=[path])
    assert again.verified
    assert [each.kind for each in again.attempts] == [SeedKind.GIVEN]
    assert again.won is not None and again.won.kind is SeedKind.GIVEN
    assert again.counts["qp_solves"] < solved.counts["qp_solves"]


def test_a_motion_and_an_array_are_paths_too(solved: to.Result) -> None:
    motion = solved.require().trajectory
    for seed in (motion, motion.positions, motion.positions.tolist()):
        assert to.plan(solved.problem, seeds=[seed]).attempts[0].kind is SeedKind.GIVEN


def test_it_is_moved_to_the_start_and_the_goal(solved: to.Result) -> None:
    """Of a problem that begins elsewhere, by a tenth of a radian."""
    path = solved.require().path
    start = solved.problem.start_positions.copy()
    start[:2] += 0.1
    moved = to.plan(replace(solved.problem, start=start), seeds=[path])
    assert moved.verified
    np.testing.assert_allclose(moved.require().path.knots[0], moved.problem.reduced.start_positions)


def test_joints_go_by_their_names(solved: to.Result) -> None:
    path = solved.require().path
    turned = Path(path.joint_names[::-1], path.knots[:, ::-1])
    one, other = (to.plan(solved.problem, seeds=[each]) for each in (path, turned))
    np.testing.assert_array_equal(one.require().trajectory.positions, other.require().trajectory.positions)


def test_a_useless_path_costs_only_one_attempt(solved: to.Result) -> None:
    rng = np.random.default_rng(3)
    wild = rng.uniform(-3.0, 3.0, (9, len(solved.problem.reduced.joint_names)))
    result = to.plan(solved.problem, seeds=[wild])
    assert result.verified
    assert result.attempts[0].kind is SeedKind.GIVEN


def test_invalid_paths_are_refused(solved: to.Result) -> None:
    joints = solved.problem.reduced.joint_names
    with pytest.raises(ShapeError, match=r"seeds\[1\]"):
        to.plan(solved.problem, seeds=[solved.require().path, np.zeros((4, 3))])
    with pytest.raises(ProblemError, match="at least two knots"):
        to.plan(solved.problem, seeds=[np.zeros((1, len(joints)))])
    with pytest.raises(JointNotFound, match=r"joint of seeds\[0\]"):
        to.plan(solved.problem, seeds=[Path(("elbow", *joints[1:]), np.zeros((2, len(joints))))])
    with pytest.raises(ProblemError, match="waypoints"):
        to.plan(replace(solved.problem, waypoints=[solved.problem.goals]), seeds=[solved.require().path])
