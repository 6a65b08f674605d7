"""Goals, waypoints, starts and couplings that name a mimic joint are held by the joint that it follows."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robot.test_mimics import planar
from trajopt.optimise.kinematics import inverse_kinematics
from trajopt.optimise.terms.joint_positions import fixed_positions, joint_box, without_followers
from trajopt.planning.infeasibility.exclusion import exclusion
from trajopt.planning.status import Status
from trajopt.problem.requirements import JointPositions
from trajopt.why import Certainty


@pytest.fixture
def chain(tmp_path: Path) -> to.Robot:
    """Three joints in a plane; m1 follows j1 backwards at half speed, m2 follows m1."""
    return planar(tmp_path, {"m1": ("j1", -0.5, 0.1), "m2": ("m1", 1.0, 0.0)})


def problem(robot: to.Robot, goal: to.Requirement | list[to.Requirement], **more: object) -> to.Problem:
    return to.Problem(scene=to.Scene(robot), start={"j1": 0.0}, goal=goal, **more)  # type: ignore[arg-type]


def ends(robot: to.Robot, result: to.Result) -> dict[str, float]:
    reached = result.problem.reduced.all_positions(result.require().trajectory.positions[-1])
    return dict(zip(robot.joint_names, reached.tolist(), strict=True))


@pytest.mark.parametrize("joint", ["m1", "m2"])
@pytest.mark.parametrize("room", [0.01, 0.3])
def test_a_goal_of_a_mimic_joint_is_held(chain: to.Robot, joint: str, room: float) -> None:
    result = to.plan(problem(chain, to.joint_positions({joint: -0.4}, tolerance=room)))
    assert result.verified, result.reason
    assert abs(ends(chain, result)[joint] + 0.4) <= room + 1e-9


def test_tolerances_change_sides_with_the_sign_of_the_factor(chain: to.Robot) -> None:
    reduced = problem(chain, to.joint_positions({"j1": 0.0})).reduced
    goal = to.joint_positions({"m1": -0.4}, below={"m1": 0.1}, above={"m1": 0.3})
    (stated,) = without_followers((goal,), reduced)
    assert isinstance(stated, JointPositions)
    assert stated.positions["j1"] == pytest.approx(1.0)
    assert (stated.below["j1"], stated.above["j1"]) == pytest.approx((0.6, 0.2))
    lower, upper = joint_box((goal,), reduced)
    assert (lower[0], upper[0]) == pytest.approx((0.4, 1.2))
    # A leader and its follower in one goal share what both allow.
    both = to.joint_positions({"j1": 0.9, "m1": -0.4}, tolerance=0.1)
    lower, upper = joint_box((both,), reduced)
    assert (lower[0], upper[0]) == pytest.approx((0.8, 1.0))
    middle = fixed_positions((both,), reduced)
    assert middle is not None and middle[0] == pytest.approx(0.9)


def test_leader_and_follower_that_exclude_each_other_are_a_proven_conflict(chain: to.Robot) -> None:
    leader, follower = to.joint_positions({"j1": 0.0}), to.joint_positions({"m2": -0.4})
    together = to.joint_positions({"j1": 0.0, "m2": -0.4})
    for goal in ([leader, follower], [together]):
        result = to.plan(problem(chain, goal))
        assert result.status is Status.CONFLICTING_CONSTRAINTS and "j1" in result.reason
        assert result.certainty is Certainty.PROVEN
    assert exclusion(leader, follower, problem(chain, leader).reduced)


def test_a_mimic_goal_beyond_its_leader_is_refused_by_name(chain: to.Robot) -> None:
    result = to.plan(problem(chain, to.joint_positions({"m1": -2.9})))
    assert result.status is Status.GOAL_OUT_OF_LIMITS and "j1" in result.reason


def test_inverse_kinematics_holds_a_mimic_joint(chain: to.Robot) -> None:
    reduced = problem(chain, to.joint_positions({"j1": 0.0})).reduced
    (found,) = inverse_kinematics(reduced, to.joint_positions({"m1": -0.4})).free
    assert found[0] == pytest.approx(1.0, abs=1e-3)


def test_waypoints_and_couplings_name_mimic_joints(chain: to.Robot) -> None:
    result = to.plan(
        problem(
            chain,
            to.joint_positions({"j1": 0.5}),
            waypoints=[to.joint_positions({"m2": -0.4}, tolerance=0.02)],
            constraints=[to.coupled_joints({"m1": 1.0, "m2": -1.0}, tolerance=0.01)],
        )
    )
    assert result.verified, result.reason
    moved = result.require().trajectory.positions[:, 0]
    assert np.abs(-0.5 * moved + 0.1 + 0.4).min() < 0.1


def test_a_start_that_names_only_a_mimic_joint_places_its_leader(chain: to.Robot) -> None:
    placed = dict(zip(chain.joint_names, chain.positions({"m2": -0.4}).tolist(), strict=True))
    assert placed == pytest.approx({"j1": 1.0, "m1": -0.4, "m2": -0.4})
    started = to.Problem(scene=to.Scene(chain), start={"m1": -0.4}, goal=to.joint_positions({"j1": 0.0}))
    assert started.reduced.start_positions[0] == pytest.approx(1.0)


def test_reports_a_mimic_joint_whose_leader_is_fixed(tmp_path: Path) -> None:
    robot = planar(tmp_path, {"m1": ("j1", 0.0, 0.2)})
    with pytest.raises(to.TrajoptError, match=r"with factor 0 and stays at 11\.46 deg \(0\.2000 rad\)"):
        to.plan(problem(robot, to.joint_positions({"m1": -0.4})))
