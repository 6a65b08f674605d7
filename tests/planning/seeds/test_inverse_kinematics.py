"""Goal configurations: each holds the goal, the nearest comes first, and failures say why."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.geometry import evaluator
from trajopt.optimise.kinematics.inverse import GoalCandidates, goal_candidates
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model


@pytest.fixture
def scene(tmp_path: Path) -> to.Scene:
    return to.Scene(odd_arm(tmp_path))


def search(scene: to.Scene, *goals: to.Requirement, seed: int = 0) -> tuple[ReducedModel, GoalCandidates]:
    reduced = reduce_model(scene, "all", scene.robot.positions())
    rng = np.random.default_rng(seed)
    return reduced, goal_candidates(evaluator(reduced), goals, rng=rng)


def test_position_goal(scene: to.Scene) -> None:
    where = scene.placement_of("tip", scene.robot.positions({"pan": 0.8, "reach": 0.2, "elbow": -0.7}))
    goal = to.frame_placement("tip", where, rotation_tolerance=np.inf, offset=(0.02, 0.0, 0.01))
    reduced, found = search(scene, goal)
    assert len(found.free) >= 2
    travel: list[float] = []
    for q in found.free:
        tip = scene.placement_of("tip", reduced.all_positions(q))
        error = where.rotation.T @ (tip * goal.offset - where.translation)
        assert np.abs(error).max() <= 1e-4
        assert (q >= reduced.limits.lower).all() and (q <= reduced.limits.upper).all()
        travel.append(float(np.max(np.abs(q - reduced.start_positions) / reduced.limits.velocity)))
    assert all(later >= earlier / 1.01 for earlier, later in pairwise(travel))


def test_free_axes_and_attached_objects(scene: to.Scene) -> None:
    scene = scene.add(
        "held",
        to.Sphere(0.02),
        to.placement((0.12, 0, 0), rpy=(0, 0.4, 0)),
        frame="tip",
        touch_links=["tip", "finger"],
    )
    where = scene.placement_of("held", scene.robot.positions({"pan": 0.3, "reach": 0.1, "elbow": 0.4}))
    goal = to.frame_placement(
        "held", where, position_tolerance=(1e-3, 1e-3, np.inf), rotation_tolerance=np.inf
    )
    reduced, found = search(scene, goal)
    for q in found.free:
        seen = where.inverse() * scene.placement_of("held", reduced.all_positions(q)).translation
        assert np.abs(seen[:2]).max() <= 1e-3
    assert found.free


def test_alignment_goal(scene: to.Scene) -> None:
    goal = to.axis_alignment("tip", axis=(1, 0, 0), direction=(0, 0, -1), tolerance=0.1)
    reduced, found = search(scene, goal)
    for q in found.free:
        tip = scene.placement_of("tip", reduced.all_positions(q))
        assert np.arccos(-tip.rotation[2, 0]) <= 0.1 + 1e-9
    assert found.free


def test_the_blocking_pair_is_named(scene: to.Scene) -> None:
    where = scene.placement_of("tip", scene.robot.positions({"pan": 0.8, "reach": 0.2}))
    scene = scene.add("block", to.Box(0.2, 0.2, 0.2), to.placement(where.translation))
    _, found = search(scene, to.frame_placement("tip", where, rotation_tolerance=np.inf))
    assert not found.free and found.colliding > 0
    assert found.blocking is not None and "block" in found.blocking[:2] and found.blocking[2] < 0.0


def test_reports_the_distance_of_an_unreachable_goal(scene: to.Scene) -> None:
    goal = to.frame_placement("tip", to.placement((3.0, 0, 0)), rotation_tolerance=np.inf)
    _, found = search(scene, goal)
    assert not found.free and found.colliding == 0
    assert 1.0 < found.nearest_miss < 3.0


def test_the_same_every_time(scene: to.Scene) -> None:
    where = to.placement((0.5, 0.3, 0.3), rotation=Rotation.from_euler("z", 0.3).as_matrix())
    goal = to.frame_placement("tip", where, rotation_tolerance=np.inf)
    first, second = (search(scene, goal, seed=3)[1].free for _ in range(2))
    assert all(np.array_equal(a, b) for a, b in zip(first, second, strict=True))


def test_a_goal_near_the_edge_of_a_path_constraint_is_found() -> None:
    """Within a twentieth of the edge it was said to conflict with the constraint."""
    arm = to.load("planar2")
    first, second = arm.joint_names
    scene = to.Scene(arm)
    there = scene.placement_of("tool", arm.positions({first: 0.5, second: 1.49}))
    problem = to.Problem(
        scene=scene,
        start=[0.0, 1.0],
        goal=to.frame_placement("tool", there, rotation_tolerance=np.inf),
        constraints=[to.joint_positions({second: 1.0}, tolerance=0.5)],
    )
    assert to.plan(problem).verified
