"""The plane of a path and time: what blocks where and when, against checks every millisecond."""

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from tests.verify.test_moving_things import alone
from trajopt.geometry import DynamicObstacles, evaluator
from trajopt.planning.moving.path_time import FREE, blocked_cells, forbidden_times
from trajopt.planning.moving.sampled_checks import SampledChecks
from trajopt.scene.reduced import ReducedModel, TimedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.errors import ShapeError


def checks_among(timed: TimedModel) -> SampledChecks:
    return SampledChecks(DynamicObstacles(timed, evaluator(timed.reduced)))


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    return odd_arm(tmp_path_factory.mktemp("robot"))


def swinging(reduced: ReducedModel, rng: np.random.Generator) -> to.Trajectory:
    points = rng.uniform(-1.0, 1.0, (3, len(reduced.joint_names)))
    rest = np.zeros_like(points)
    return to.Trajectory(reduced.joint_names, np.array((0.0, 0.5, 1.0)), points, rest, rest.copy())


def crowded(arm: to.Robot, rng: np.random.Generator) -> to.Scene:
    """Return a scene in which balls fly through the arm's room, one with a growing error, one for a while."""
    scene = alone(arm)
    for number in [0, 1, 3]:
        ends = [to.placement(rng.uniform(-0.7, 0.7, 3)) for _ in range(3)]
        track = to.Track.through(np.array((0.0, 1.2, 2.4)), ends)
        motion = to.Prediction(track, (0.0, 0.05 * (number == 1), 0.01))
        appears, expires = (0.7, 1.3) if number == 2 else (None, None)
        scene = scene.add(f"ball {number}", to.Sphere(0.08), motion=motion, appears=appears, expires=expires)
    return scene


@pytest.mark.parametrize("seed", [0, 1, 3])
def test_blocked_cells_equal_checks_every_millisecond(arm: to.Robot, seed: int) -> None:
    rng = np.random.default_rng(seed)
    reduced = reduce_model(crowded(arm, rng), "all", np.zeros(len(arm.joint_names)))
    motion, timed = swinging(reduced, rng), reduced.timed
    assert timed is not None
    edges, times = np.linspace(0.0, 1.0, 31), np.linspace(0.0, 2.4, 121)
    checks, each = checks_among(timed), checks_among(timed)
    checks.start_at(motion(np.zeros(1)))
    each.start_at(motion(np.zeros(1)))
    found = blocked_cells(checks, motion, edges, times)
    assert checks.obstacles.query.counts.forward_kinematics < found.size, "some cells are not looked at"
    late = np.arange(0.0, 2.4, 1e-3) + 5e-4  # twenty checks into each cell
    none, blocked = np.zeros(len(late)), np.zeros((30, 120, 20), dtype=np.bool_)
    for part, place in enumerate(((edges[:-1] + edges[1:]) / 2.0).tolist()):
        rows = np.repeat(motion(np.array([place])), len(late), axis=0)
        seen = each.check(rows, late, np.stack((none, none), 1), none)
        blocked[part] = seen.near.reshape(120, 20)
    always, never = blocked.all(axis=2), ~blocked.any(axis=2)
    assert always.any() and never.sum() > 1000
    assert (found[always] != FREE).all() and (found[never] == FREE).all()
    soon = blocked_cells(checks, motion, edges, times[:71], hurried=True)
    reached = (times[1:71] > edges[:-1, None]) & (1.4 - times[:70] > 1.0 - edges[1:, None])
    within = reached & entered(found[:, :70] == FREE)
    assert (soon[within] == found[:, :70][within]).all() and within.any()
    assert (soon == FREE).sum() >= (found[:, :70] == FREE).sum()
    for pair in np.unique(found[found != FREE]).tolist():
        assert checks.mover(pair).startswith("ball")


def entered(free: np.ndarray) -> np.ndarray:
    """Return the cells that a motion can be in or would come to next, if it gets on by a cell at a time."""
    found = np.zeros_like(free)
    found[:2, 0] = True
    for moment in range(free.shape[1] - 1):
        for part in np.flatnonzero(found[:, moment] & free[:, moment]).tolist():
            found[part : part + 2, moment + 1] = True
    return found


def test_cells_behind_a_permanent_block_are_not_checked(arm: to.Robot) -> None:
    scene = alone(arm)
    reduced = reduce_model(scene, "all", np.zeros(len(arm.joint_names)))
    motion = swinging(reduced, np.random.default_rng(0))
    # It falls on the arm, wherever that is by then, and stays there.
    hand = scene.placement_of(arm.links[-1], reduced.all_positions(motion(0.0)))
    away = to.placement(hand.translation + np.array((0.0, 0.0, 3.0)))
    falls = to.Track.through([0.0, 1.0], [away, hand])
    reduced = reduce_model(
        scene.add("ball", to.Sphere(1.5), motion=falls), "all", np.zeros(len(arm.joint_names))
    )
    timed = reduced.timed
    assert timed is not None
    edges, times = np.linspace(0.0, 1.0, 51), np.linspace(0.0, 20.0, 1001)
    looked: dict[bool, int] = {}
    for hurried in (False, True):
        checks = checks_among(timed)
        checks.start_at(motion(np.zeros(1)))
        found = blocked_cells(checks, motion, edges, times, hurried=hurried)
        looked[hurried] = checks.obstacles.query.counts.forward_kinematics
        assert (found[0, 40:64] != FREE).any()
    assert looked[True] < looked[False] / 2


def test_the_plane_of_a_plan_shows_that_it_passes_where_nothing_is_in_the_way(arm: to.Robot) -> None:
    del arm
    planar = to.Scene(to.load("planar2"))
    hand = planar.placement_of("tool", np.array((0.0, 0.3))).translation
    crossing = to.Track.through(
        [0.0, 0.4, 0.8], [to.placement((x, hand[1], hand[2])) for x in (2.5, hand[0], 2.5)]
    )
    scene = planar.add("ball", to.Sphere(0.08), motion=crossing)
    problem = to.Problem(
        scene=scene,
        start={"joint1": -1.0, "joint2": 0.3},
        goal=to.joint_positions({"joint1": 1.0, "joint2": 0.3}),
    )
    result = to.plan(problem)
    plane = forbidden_times(result)
    assert plane.objects == ("ball",)
    assert plane.blocked.shape == (len(plane.places) - 1, len(plane.times) - 1)
    assert (plane.blocked == 0).any() and plane.chosen_places[0] == 0.0 and plane.chosen_places[-1] == 1.0
    part = np.clip(
        np.searchsorted(plane.places, plane.chosen_places, side="right") - 1, 0, len(plane.places) - 2
    )
    late = np.clip(
        np.searchsorted(plane.times, plane.chosen_times, side="right") - 1, 0, len(plane.times) - 2
    )
    assert (plane.blocked[part, late] == FREE).mean() > 0.97, "but for halves of cells along borders"
    with pytest.raises(ShapeError, match="until"):
        forbidden_times(result, until=0.0)


def test_nothing_blocks_where_nothing_changes() -> None:
    scene = to.Scene(to.load("planar2"))
    goal = to.joint_positions({"joint1": 0.5, "joint2": 0.1})
    plane = forbidden_times(to.plan(to.Problem(scene=scene, start={"joint1": 0.0, "joint2": 0.3}, goal=goal)))
    assert plane.objects == () and (plane.blocked == FREE).all()
