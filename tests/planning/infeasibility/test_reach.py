"""Bounds of reach hold at every configuration, and what is proven out of reach is."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.geometry import Query
from trajopt.planning.infeasibility import out_of_reach
from trajopt.planning.infeasibility.joint_bounds import Chain
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.shapes.shapes import bounding_sphere


@pytest.fixture(scope="module")
def reduced(tmp_path_factory: pytest.TempPathFactory) -> ReducedModel:
    folder: Path = tmp_path_factory.mktemp("robot")
    robot = odd_arm(folder)
    return reduce_model(to.Scene(robot), "all", robot.positions({}))


def drawn(reduced: ReducedModel, count: int) -> np.ndarray:
    limits, rng = reduced.limits, np.random.default_rng(3)
    return rng.uniform(np.maximum(limits.lower, -np.pi), np.minimum(limits.upper, np.pi), (count, 4))


def test_levers_bound_every_motion_of_every_body(reduced: ReducedModel) -> None:
    chain, query, rng = Chain(reduced), Query(reduced), np.random.default_rng(1)
    for q in drawn(reduced, 40):
        step = rng.uniform(-0.3, 0.3, 4)
        seen = query.kinematics(np.stack((q, q + step)))
        for number, body in enumerate(reduced.bodies):
            centre, radius = bounding_sphere(body.shape)
            around = rng.normal(size=(20, 3))
            points = body.placement * (centre + radius * around / np.linalg.norm(around, axis=1)[:, None])
            at = (
                points @ np.swapaxes(seen.rotation[:, body.joint], 1, 2)
                + seen.translation[:, body.joint][:, None]
            )
            moved = np.linalg.norm(at[1] - at[0], axis=1).max()
            assert moved <= chain.levers(number) @ np.abs(step) + 1e-9


def test_reached_points_are_never_reported_out_of_reach(reduced: ReducedModel) -> None:
    for q in drawn(reduced, 60):
        where = reduced.scene.placement_of("tip", reduced.all_positions(q))
        offset = (0.02, 0.0, 0.1)
        point = where * np.array(offset)
        circle = to.placement(point - [0.1, 0, 0])
        for required in (
            to.frame_placement("tip", to.placement(point), position_tolerance=0.0, offset=offset),
            to.position_in_region("tip", to.Sphere(1e-3), to.placement(point), offset=offset),
            to.point_on_arc("tip", circle, radius=0.1, tolerance=1e-3, offset=offset),
        ):
            assert out_of_reach(required, reduced) == ""


def test_far_away_is_out_of_reach(reduced: ReducedModel) -> None:
    longest = Chain(reduced).longest(1, reduced.attachment("tip")[0], np.zeros(3))
    near, far = (to.placement((0.0, longest + extra, 0.1)) for extra in (-0.001, 0.02))
    assert out_of_reach(to.frame_placement("tip", near), reduced) == ""
    assert "20 mm too short" in out_of_reach(to.frame_placement("tip", far, position_tolerance=0.0), reduced)
    assert "" != out_of_reach(to.position_in_region("tip", to.Sphere(0.01), far), reduced)
    assert "" == out_of_reach(to.position_in_region("tip", to.Plane(), far), reduced)


def test_points_that_move_along_are_not_a_proof(reduced: ReducedModel) -> None:
    far = to.frame_placement("tip", to.placement((0.0, 5.0, 0.0)), reference="fore")
    assert out_of_reach(far, reduced) == ""


def test_tolerances_along_a_turned_goal_prove_nothing_along_the_axes_of_its_reference() -> None:
    """A goal held 10 mm from its middle was proven to break such a path constraint everywhere."""
    arm = to.load("planar2")
    scene, goal = to.Scene(arm), dict.fromkeys(arm.joint_names, 0.5)
    middle = scene.placement_of("tool", arm.positions(goal)).translation
    turned = to.placement(middle + np.array([0.02, 0.3, 0.0]), rpy=(0.0, 0.0, np.pi / 2))
    beside = to.frame_placement(
        "tool", turned, position_tolerance=(0.5, 0.01, np.inf), rotation_tolerance=np.inf
    )
    problem = to.Problem(
        scene=scene,
        start=[0.107, 0.952],
        goal=to.joint_positions(goal, tolerance=0.2),
        constraints=[beside],
    )
    assert to.plan(problem).verified
