"""Goals of every kind, alone and together: what is found holds by formulas that share nothing with it."""

from collections.abc import Callable
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import trajopt as to
from tests.planning.seeds.placo_search import PlacoSearch
from tests.robots_for_tests import odd_arm, two_arms
from trajopt.geometry import evaluator
from trajopt.optimise.kinematics.inverse import GoalCandidates, goal_candidates
from trajopt.problem.requirements import AxisAlignment, FramePlacement, JointPositions, RotationCoordinates
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model

SAME = 1e-2


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    return odd_arm(tmp_path_factory.mktemp("robot"))


def random_start(robot: to.Robot, group: str, rng: np.random.Generator) -> NDArray[np.float64]:
    """Draw positions of a group; what mimics follows, all else stands at its default."""
    full = np.array(robot.positions())
    places = robot.index(robot.group(group).joints)
    limits = robot.limits.take(places)
    lower, upper = np.maximum(limits.lower, -np.pi), np.minimum(limits.upper, np.pi)
    full[places] = rng.uniform(lower, upper)
    named = dict(zip(robot.joint_names, full.tolist(), strict=True))
    free = {name: value for name, value in named.items() if name not in robot.mimics}
    return robot.positions(free)


def error_of(goal: to.Requirement, scene: to.Scene, full: NDArray[np.float64]) -> float:
    """Return by how much a goal is missed, from placements of the full model: 0 or less is held."""
    match goal:
        case FramePlacement():
            base = scene.placement_of(goal.reference, full) if goal.reference != "world" else to.placement()
            wanted = base * goal.placement
            seen = scene.placement_of(goal.frame, full)
            position = wanted.rotation.T @ (seen * goal.offset - wanted.translation)
            turn = Rotation.from_matrix(wanted.rotation.T @ seen.rotation)
            euler = goal.coordinates is RotationCoordinates.XYZ_EULER
            angles = turn.as_euler("XYZ") if euler else turn.as_rotvec()
            tolerance = np.concatenate((goal.position_tolerance, goal.rotation_tolerance))
            return float((np.abs(np.concatenate((position, angles))) - tolerance).max())
        case AxisAlignment():
            base = scene.placement_of(goal.reference, full) if goal.reference != "world" else to.placement()
            axis = scene.placement_of(goal.frame, full).rotation @ goal.axis
            return float(np.arccos(np.clip(axis @ base.rotation @ goal.direction, -1, 1))) - goal.tolerance
        case JointPositions():
            seen = {name: float(full[scene.robot.index([name])[0]]) for name in goal.positions}
            above = [seen[name] - value - goal.above[name] for name, value in goal.positions.items()]
            below = [value - seen[name] - goal.below[name] for name, value in goal.positions.items()]
            return max(above + below)
        case _:
            raise NotImplementedError


def search(
    scene: to.Scene, group: str, start: NDArray[np.float64], goals: tuple[to.Requirement, ...], seed: int = 0
) -> tuple[ReducedModel, GoalCandidates]:
    reduced = reduce_model(scene, group, start)
    return reduced, goal_candidates(evaluator(reduced), goals, rng=np.random.default_rng(seed))


def assert_held(reduced: ReducedModel, found: GoalCandidates, goals: tuple[to.Requirement, ...]) -> None:
    limits = reduced.limits
    for q in found.free:
        full = reduced.all_positions(q)
        for goal in goals:
            assert error_of(goal, reduced.scene, full) <= 1e-9, goal
        assert (q >= limits.lower).all() and (q <= limits.upper).all()
    for one, other in combinations(found.free, 2):
        assert np.abs(one - other).max() >= SAME
    travel = [float(np.max(np.abs(q - reduced.start_positions) / limits.velocity)) for q in found.free]
    assert all(later >= earlier / 1.01 for earlier, later in pairwise(travel))


FREE = np.inf
Goals = Callable[[to.Placement, to.Placement, float], tuple[to.Requirement, ...]]
MIXES: dict[str, Goals] = {
    "placement": lambda tip, held, reach: (to.frame_placement("tip", tip),),
    "tool point in Euler angles": lambda tip, held, reach: (
        to.frame_placement(
            "held",
            to.Placement(held.rotation, held * np.array((0.0, 0.01, 0.1))),
            offset=(0.0, 0.01, 0.1),
            rotation_tolerance=(0.02, FREE, 0.1),
            coordinates=RotationCoordinates.XYZ_EULER,
        ),
    ),
    "point": lambda tip, held, reach: (to.frame_placement("tip", tip, rotation_tolerance=FREE),),
    "point exactly": lambda tip, held, reach: (
        to.frame_placement("tip", tip, position_tolerance=0.0, rotation_tolerance=FREE),
    ),
    "wide and narrow": lambda tip, held, reach: (
        to.frame_placement(
            "tip", tip, position_tolerance=(1e-4, 0.05, FREE), rotation_tolerance=(0.3, FREE, 0.5)
        ),
    ),
    "height and axis": lambda tip, held, reach: (
        to.frame_placement(
            "tip",
            to.placement(tip.translation),
            position_tolerance=(FREE, FREE, 1e-3),
            rotation_tolerance=FREE,
        ),
        to.axis_alignment("tip", axis=(1, 0, 0), direction=tip.rotation[:, 0], tolerance=0.2),
    ),
    "axis": lambda tip, held, reach: (
        to.axis_alignment("held", axis=(0, 0, 1), direction=held.rotation[:, 2], tolerance=0.01),
    ),
    "point and a joint": lambda tip, held, reach: (
        to.frame_placement("tip", tip, position_tolerance=1e-3, rotation_tolerance=FREE),
        to.joint_positions({"reach": reach}, tolerance=0.02),
    ),
    "joints": lambda tip, held, reach: (to.joint_positions({"reach": reach, "elbow": 0.5}),),
}


@pytest.mark.parametrize("mix", MIXES)
@pytest.mark.parametrize("seed", range(8))
def test_every_kind_of_goal(arm: to.Robot, mix: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    held = to.placement((0.12, 0, 0), rpy=(0, 0.4, 0.2))
    scene = to.Scene(arm).add("held", to.Sphere(0.02), held, frame="tip", touch_links=["tip", "finger"])
    start, at = random_start(arm, "all", rng), random_start(arm, "all", rng)
    reach = float(at[arm.index(["reach"])[0]])
    goals = MIXES[mix](scene.placement_of("tip", at), scene.placement_of("held", at), reach)
    reduced, found = search(scene, "all", start, goals)
    assert len(found.free) + found.colliding > 0
    assert_held(reduced, found, goals)


@pytest.mark.parametrize("seed", range(8))
def test_a_reference_that_moves(tmp_path: Path, seed: int) -> None:
    robot, rng = two_arms(tmp_path), np.random.default_rng(seed)
    scene, at = to.Scene(robot), random_start(robot, "both", rng)
    seen = scene.placement_of("left_hand", at).inverse() * scene.placement_of("tool", at)
    goals = (to.frame_placement("tool", seen, reference="left_hand", rotation_tolerance=FREE),)
    reduced, found = search(scene, "both", random_start(robot, "both", rng), goals)
    assert len(found.free) + found.colliding > 0
    assert_held(reduced, found, goals)


def test_a_joint_goal_keeps_its_turn(arm: to.Robot) -> None:
    """The turn nearest to the start is taken only where the goal leaves the choice."""
    start = arm.positions({"pan": 3.0})
    _, found = search(to.Scene(arm), "all", start, (to.joint_positions({"pan": -3.0}),))
    assert found.free and all(q[0] == pytest.approx(-3.0, abs=1e-4) for q in found.free)


def test_intended_contact_at_the_end_is_not_a_collision(arm: to.Robot) -> None:
    at = arm.positions({"pan": 0.5, "reach": 0.1, "elbow": 0.3})
    scene = to.Scene(arm).add(
        "part", to.Sphere(0.05), to.placement((0.15, 0, 0)), frame="tip", touch_links=["tip", "finger"]
    )
    where = scene.placement_of("part", at)
    scene = scene.add("shelf", to.Box(0.1, 0.1, 0.02), to.placement(where.translation - [0, 0, 0.0595]))
    goals = (to.frame_placement("part", where, rotation_tolerance=FREE, position_tolerance=1e-4),)
    blocked = search(scene, "all", arm.positions(), goals)[1]
    assert not blocked.free and blocked.blocking is not None and "shelf" in blocked.blocking
    meant = scene.allow_contact("put down", "part", "shelf", depth=2e-3, last=0.5)
    assert search(meant, "all", arm.positions(), goals)[1].free


def test_as_many_solutions_as_placo() -> None:
    """Six joints have few solutions: all that placo finds from many starts are found."""
    try:
        robot = to.load("ur5")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    scene, rng, ours, placos = to.Scene(robot), np.random.default_rng(1), 0, 0
    for _ in range(8):
        where = scene.placement_of("tool0", random_start(robot, "manipulator", rng))
        start = random_start(robot, "manipulator", rng)
        reduced, found = search(scene, "manipulator", start, (to.frame_placement("tool0", where),))
        assert_held(reduced, found, (to.frame_placement("tool0", where),))
        ours += len(found.free) + found.colliding
        placo = PlacoSearch(robot, "manipulator", "tool0", where)
        distinct: list[NDArray[np.float64]] = []
        for begin in rng.uniform(-np.pi, np.pi, (32, 6)):
            q = placo(begin)
            seen = scene.placement_of("tool0", reduced.all_positions(q))
            held = np.abs(seen.translation - where.translation).max() < 1e-4
            held &= Rotation.from_matrix(seen.rotation.T @ where.rotation).magnitude() < 1e-3
            away = [np.abs(np.angle(np.exp(1j * (q - other)))).max() for other in distinct]
            if held and min(away, default=np.inf) > SAME:
                distinct.append(q)
        placos += len(distinct)
    assert ours >= placos > 16
