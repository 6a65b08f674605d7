"""Inverse kinematics: what is found holds, is ordered and distinct; what is not found is explained."""

from itertools import pairwise

import numpy as np
import pytest

import trajopt as to
from trajopt.optimise.kinematics import forward_kinematics, inverse_kinematics, validity
from trajopt.optimise.kinematics.inverse import with_start
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.arrays import Floats

TCP = "panda_hand_tcp"


def travel(reduced: ReducedModel, begin: Floats, found: tuple[Floats, ...]) -> list[float]:
    return [float(np.max(np.abs(q - begin) / reduced.limits.velocity)) for q in found]


def test_solutions_hold_are_distinct_and_ordered_by_distance(panda: ReducedModel) -> None:
    where = forward_kinematics(panda, TCP, panda.start_positions + 0.2)[0]
    near = panda.start_positions + np.array([0.5, 0.2, -0.4, 0.3, 0.6, 0.2, -0.3])
    found = inverse_kinematics(panda, to.frame_placement(TCP, where), near=near)
    assert len(found.free) > 5 and found.nearest is None and found.valid
    reached = forward_kinematics(panda, TCP, np.array(found.free))
    assert np.abs((reached.translation - where.translation) @ where.rotation).max() <= 1e-4
    turn = np.trace(np.swapaxes(reached.rotation, 1, 2) @ where.rotation, axis1=1, axis2=2)
    assert np.arccos(np.clip((turn - 1) / 2, -1, 1)).max() <= 1e-3 * np.sqrt(3)
    times = travel(panda, near, found.free)
    assert all(later >= earlier / 1.01 for earlier, later in pairwise(times))
    apart = np.abs(np.array(found.free)[:, None] - np.array(found.free)).max(axis=2)
    assert (apart + np.eye(len(apart)) > 1e-2).all()
    assert all(validity(panda, q).valid for q in found.free)


def test_the_redundant_joint_is_given(panda: ReducedModel) -> None:
    where = forward_kinematics(panda, TCP, panda.start_positions)[0]
    goal = to.frame_placement(TCP, where)
    for value in (-0.5, 0.3, 1.4):
        found = inverse_kinematics(panda, [goal, to.joint_positions({"panda_joint7": value})])
        assert found.free, found.explain()
        assert all(abs(q[6] - value) <= 1e-3 for q in found.free)


def test_an_attached_object_is_placed_within_its_tolerances(odd: ReducedModel) -> None:
    where = odd.scene.placement_of("ball", odd.all_positions(np.array([-0.8, 0.2, -0.3, 0.5])))
    goal = to.frame_placement(
        "ball", where, position_tolerance=(1e-3, 1e-3, np.inf), rotation_tolerance=np.inf
    )
    found = inverse_kinematics(odd, goal)
    assert found.free
    for q in (*found.free, *found.colliding):
        seen = where.inverse() * odd.scene.placement_of("ball", odd.all_positions(q)).translation
        assert np.abs(seen[:2]).max() <= 1e-3


def test_colliding_solutions_are_reported_with_pair_and_depth(panda: ReducedModel) -> None:
    where = forward_kinematics(panda, TCP, panda.start_positions)[0]
    scene = panda.scene.add("block", to.Box(0.2, 0.2, 0.2), to.placement(where.translation))
    blocked = reduce_model(scene, "panda_arm", panda.start)
    found = inverse_kinematics(blocked, to.frame_placement(TCP, where))
    assert not found.valid and found.colliding
    assert "collide; in the nearest" in found.explain() and "mm inside block" in found.explain()
    for q in found.colliding:
        assert validity(blocked, q).examination.collisions


def test_an_unreachable_pose_is_reported_with_its_error(panda: ReducedModel) -> None:
    goal = to.frame_placement(TCP, to.placement((0.0, 3.0, 0.0)), rotation_tolerance=np.inf)
    found = inverse_kinematics(panda, goal)
    assert not found.free and not found.colliding and found.nearest is not None
    (check,) = (item for item in found.nearest.checks if not item.holds)
    tip = forward_kinematics(panda, TCP, found.nearest.positions)[0].translation
    assert check.value == pytest.approx(np.abs(tip - (0.0, 3.0, 0.0)).max(), abs=1e-9)
    assert "position along y is" in found.explain()


def test_others_stay_where_they_are(pair: ReducedModel) -> None:
    moved = with_start(pair, [0.1, 0.2, 0.3, 0.4])
    assert moved.start_positions.tolist() == [0.1, 0.2, 0.3, 0.4]
    assert pair.start_positions.tolist() == [0.0, 0.0, 0.0, 0.0]


def test_misuse_is_named(odd: ReducedModel) -> None:
    with pytest.raises(to.TrajoptError, match="needs a goal"):
        inverse_kinematics(odd, [])
    with pytest.raises(to.TrajoptError, match="did you mean 'tip'"):
        inverse_kinematics(odd, to.frame_placement("tipp", to.placement()))
    with pytest.raises(to.TrajoptError, match="no joint named 'elbo'"):
        inverse_kinematics(odd, to.joint_positions({"elbo": 0.1}))


def test_joints_that_a_goal_leaves_free_stay_where_that_costs_no_time() -> None:
    """The joint that is named decides on the time; the others swung by up to 99 deg within it."""
    ur5 = to.load("ur5")
    start = dict(zip(ur5.groups["manipulator"].joints, (0.0, -1.2, 1.0, -1.5, -1.5, 0.0), strict=True))
    goal = to.joint_positions({"shoulder_pan_joint": 1.5})
    problem = to.Problem(scene=to.Scene(ur5), group="manipulator", start=start, goal=goal)
    nearest = to.goal_configurations(problem)[0]
    assert nearest - problem.reduced.start_positions == pytest.approx([1.5, 0, 0, 0, 0, 0], abs=2e-4)
