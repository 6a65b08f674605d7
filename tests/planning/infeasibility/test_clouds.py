"""Proofs beside clouds: of balls as of boxes, and none where there is room between the balls."""

import coal
import numpy as np
import pinocchio as pin
import pytest
from trajopt_problems.arms import ur5

import trajopt as to
from tests.planning.infeasibility.test_closed_cut import between_walls
from trajopt.geometry.geometry import collision_geometry
from trajopt.planning.infeasibility import box_collides, closed_cut
from trajopt.planning.status import Certainty
from trajopt.verify import Judge

SHEET = 0.02


def walls_of_points(inner: float, *, apart: float = SHEET, cells: bool = False) -> to.Problem:
    """A UR5 between two walls of balls or cubes in the place of `between_walls`."""
    solid = between_walls(inner)
    y = np.arange(-0.03, 0.031, apart)
    wall = np.stack(
        np.meshgrid(np.arange(inner, 1.4 + inner, apart), y, np.arange(-1.5, 1.5, apart)), axis=-1
    ).reshape(-1, 3)
    points = np.concatenate((wall, wall * (-1.0, 1.0, 1.0)))
    shape = (
        to.Voxels(np.floor(points / apart + 1e-6).astype(np.int64), apart)
        if cells
        else to.Points(points, apart)
    )
    scene = solid.scene.remove("walls").add("walls", shape, to.placement(rpy=(0.0, 0.0, -np.pi / 4)))
    return to.Problem(scene=scene, group=ur5().group, start=solid.start_positions, goal=solid.goal)


@pytest.mark.parametrize("cells", (False, True))
def test_a_closing_wall_closes_the_path_as_a_cloud_too(cells: bool) -> None:
    """And nothing on the cut is free, by the judge, which has a tree of its own."""
    problem = walls_of_points(0.13, cells=cells)
    cut = closed_cut(problem)
    assert cut is not None and "walls" in cut.pairs[0]
    reduced, rng = problem.reduced, np.random.default_rng(0)
    judge, place = Judge(reduced), reduced.joint_names.index(cut.joint)
    drawn = rng.uniform(reduced.limits.lower, reduced.limits.upper, (60, 6))
    drawn[:, place] = cut.position
    assert all(judge.examine(q).collisions for q in drawn)


@pytest.mark.parametrize("inner", (0.3, 0.45))
def test_a_gap_next_to_a_cloud_is_not_a_proof(inner: float) -> None:
    problem = walls_of_points(inner)
    if closed_cut(problem) is not None:
        assert not to.plan(problem).verified


def hollow(edge: float, radius: float, count: int = 4000) -> to.Points:
    """Balls on the faces of a cube about the origin."""
    random = np.random.default_rng(7)
    on = random.uniform(-0.5, 0.5, (count, 3))
    on[np.arange(count), random.integers(3, size=count)] = random.choice((-0.5, 0.5), count)
    return to.Points(edge * on, radius)


def at_goal(cloud: to.Points, *, beside: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> to.Problem:
    """Two rods whose tip ends in the middle of a cloud."""
    robot = to.load("planar2")
    goal = {"joint1": 1.2, "joint2": -0.4}
    goal = dict(zip(robot.joint_names, goal.values(), strict=True))
    scene = to.Scene(robot)
    tip = scene.placement_of("tool", np.array(list(goal.values()))).translation
    start = dict(zip(robot.joint_names, (-1.2, 0.3), strict=True))
    placed = scene.add("cloud", cloud, to.placement(tip + np.array(beside)))
    return to.Problem(scene=placed, start=start, goal=to.joint_positions(goal))


def test_a_goal_inside_a_cloud_is_reported_and_proven() -> None:
    problem = at_goal(hollow(0.12, 0.02))
    result = to.plan(problem)
    assert result.status is to.Status.GOAL_IN_COLLISION
    assert result.certainty is Certainty.PROVEN
    assert "cloud" in result.message


@pytest.mark.parametrize("seed", range(5))
def test_a_free_goal_is_never_called_blocked(seed: int) -> None:
    """Balls all around the arm at its goal, none nearer than a millimetre by Coal on single balls."""
    random = np.random.default_rng(seed)
    free = at_goal(to.Points(np.array([(0.0, 0.0, 5.0)]), 0.01))
    drawn = random.uniform(-1.3, 1.3, (1200, 3)) * (1.0, 1.0, 0.4)
    robot, radius = free.scene.robot, 0.01
    goal = np.array([1.2, -0.4])
    kept = to.Scene(robot).add("drawn", to.Points(np.array([(0.0, 0.0, 9.0)]), radius))
    clear = np.ones(len(drawn), dtype=np.bool_)
    for q in (goal, free.start_positions):
        clear &= apart(robot, q, drawn, radius) > 1e-3
    scene = kept.with_cloud("drawn", to.Points(drawn[clear], radius))
    asked = to.Problem(scene=scene, start=free.start_positions, goal=free.goal)
    result = to.plan(asked, budget=to.Budget(attempts=1))
    assert result.status not in (to.Status.GOAL_IN_COLLISION, to.Status.START_IN_COLLISION)
    assert not box_collides(asked.reduced, goal, goal)
    assert closed_cut(asked) is None or not to.plan(asked).verified


def apart(robot: to.Robot, positions: np.ndarray, points: np.ndarray, radius: float) -> np.ndarray:
    """Measure how far single balls are from all links, one by one and by Coal, shape (n,) [m]."""
    scene = to.Scene(robot)
    reduced = to.Problem(
        scene=scene, start=positions, goal=to.joint_positions({robot.joint_names[0]: 0.0})
    ).reduced
    data = reduced.model.createData()
    pin.forwardKinematics(reduced.model, data, reduced.configuration(positions))
    ball, request = coal.Sphere(radius), coal.DistanceRequest()
    found = np.full(len(points), np.inf)
    for body in reduced.bodies:
        joint = data.oMi[body.joint]
        at = coal.Transform3s(
            joint.rotation @ body.placement.rotation,
            joint.rotation @ body.placement.translation + joint.translation,
        )
        shape = collision_geometry(body.shape)
        for number, point in enumerate(points):
            there = coal.Transform3s(np.eye(3), point)
            result = coal.DistanceResult()
            found[number] = min(found[number], coal.distance(shape, at, ball, there, request, result))
    return found
