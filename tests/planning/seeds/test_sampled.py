"""The sampling planner's paths: free all along, the same again, within the work allowed."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from tests.planning.walls import GOAL, route_of, wall, walled_in
from tests.robots_for_tests import odd_arm
from trajopt.geometry import Query, WorkCounts
from trajopt.planning.seeds import NoSeed, SampledPaths, SeedKind
from trajopt.planning.seeds.sampled import STEP, sampled


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    return odd_arm(tmp_path_factory.mktemp("robot"))


def found(problem: to.Problem, seed: int, checked: int = 20_000) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return sampled(route_of(problem), rng=rng, counts=WorkCounts(), check=lambda: None, checked=checked)


def test_the_path_is_free(arm: to.Robot) -> None:
    problem = wall(arm)
    knots = found(problem, 1)
    line = route_of(problem).line.knots
    assert knots.shape == line.shape and np.array_equal(knots[[0, -1]], line[[0, -1]])
    dense = np.concatenate([np.linspace(a, b, 40) for a, b in itertools.pairwise(knots)])
    free = [not to.examine(problem.reduced, q).collisions for q in dense]
    assert np.mean(free) > 0.95, "but for corners that the knots cut"
    assert all(not to.examine(problem.reduced, q).collisions for q in knots)


def test_it_is_the_same_again_and_another_with_another_seed(arm: to.Robot) -> None:
    assert np.array_equal(found(wall(arm), 1), found(wall(arm), 1))
    assert not np.array_equal(found(wall(arm), 1), found(wall(arm), 2))


def test_one_search_does_not_change_another(arm: to.Robot) -> None:
    alone = found(wall(arm), 1)
    found(wall(arm), 2)
    assert np.array_equal(found(wall(arm), 1), alone)


def test_it_gives_up_by_count(arm: to.Robot) -> None:
    counts = WorkCounts()
    with pytest.raises(NoSeed, match="500"):
        sampled(
            route_of(walled_in(arm)),
            rng=np.random.default_rng(0),
            counts=counts,
            check=lambda: None,
            checked=500,
        )
    assert counts.forward_kinematics < 3000


def test_the_exception_that_stops_it_is_raised(arm: to.Robot) -> None:
    class Enough(Exception):
        pass

    def check() -> None:
        raise Enough

    with pytest.raises(Enough):
        sampled(route_of(walled_in(arm)), rng=np.random.default_rng(0), counts=WorkCounts(), check=check)


def test_path_constraints_are_held_by_projection(arm: to.Robot) -> None:
    problem = wall(arm)
    kept = to.joint_positions({"wrist": 0.0}, tolerance=0.2)
    asked = to.Problem(scene=problem.scene, start=problem.start, goal=problem.goals, constraints=[kept])
    free = [found(problem, seed) for seed in range(4)]
    assert max(np.abs(knots[:, 3]).max() for knots in free) > 0.2, "without the constraint it turns"
    for seed in range(4):
        assert np.abs(found(asked, seed)[:, 3]).max() <= 0.2 + 1e-9


def test_it_leads_to_a_goal_that_can_be_reached(arm: to.Robot) -> None:
    context = route_of(walled_in(arm))
    here = context.line.knots[0] + (-0.3, 0.1, 0.2, 0.3)
    either = replace(context, other_ends=(here,))
    assert np.array_equal(either.ends, np.stack((context.line.knots[-1], here)))
    knots = sampled(either, rng=np.random.default_rng(0), counts=WorkCounts(), check=lambda: None)
    assert np.array_equal(knots[-1], here)


def test_it_stops_at_waypoints(arm: to.Robot) -> None:
    problem = wall(arm)
    context = route_of(problem)
    middle = context.line.knots[0] + (-0.2, 0.1, 0.0, 0.4)
    knots = context.line.knots.copy()
    knots[7] = middle
    through = replace(context, line=replace(context.line, knots=knots, places=(7,)))
    path = sampled(through, rng=np.random.default_rng(0), counts=WorkCounts(), check=lambda: None)
    assert np.array_equal(path[7], middle) and path.shape == knots.shape


def test_every_second_search_lets_bodies_overlap_by_their_margin(arm: to.Robot) -> None:
    problem = wall(arm)
    pairs = problem.reduced.pairs

    def nearest(path: np.ndarray) -> float:
        return float(Query(problem.reduced).close_pairs(path, pairs.margin + 1.0).distance.min())

    makes = itertools.islice(SampledPaths().seeds(route_of(problem), (), np.random.default_rng(0)), 20)
    found = [nearest(make(WorkCounts(), lambda: None)) for make in makes]
    deepest = -float((pairs.margin - pairs.required).max()) - 0.5 * STEP
    assert min(found[0::2]) > 0.0 > min(found[1::2]) > deepest


@pytest.mark.timeout(60)
@pytest.mark.parametrize("bound", ["lower", "upper"])
def test_an_end_a_hair_beyond_a_limit_is_left_and_reached(arm: to.Robot, bound: str) -> None:
    problem = wall(arm)
    context = route_of(problem)
    limit = getattr(problem.reduced.limits, bound)[3]
    knots = context.line.knots.copy()
    for place in (0, -1):
        knots[place, 3] = limit + np.sign(limit) * 1e-9
        asked = replace(context, line=replace(context.line, knots=knots))
        path = sampled(asked, rng=np.random.default_rng(3), counts=WorkCounts(), check=lambda: None)
        assert np.array_equal(path[[0, -1]], knots[[0, -1]])


def test_planning_uses_it_where_the_straight_line_fails(arm: to.Robot) -> None:
    result = to.plan(wall(arm))
    assert result.verified
    assert result.won is not None and result.attempts[0].kind is SeedKind.STRAIGHT
    assert GOAL["pan"] == pytest.approx(result.require().trajectory.positions[-1][0])


def test_no_longer_search_follows_one_that_exhausted_two_joints(planar_arm: to.Robot) -> None:
    """Nothing leads past a post near the shoulder: longer searches took half a minute to find that."""
    scene = to.Scene(planar_arm).add("post", to.Box(0.1, 0.1, 1.0), to.placement((0.25, 0.0, 0.0)))
    start = {"shoulder": -1.0, "elbow": 0.3}
    problem = to.Problem(
        scene=scene, group="arm", start=start, goal=to.joint_positions({**start, "shoulder": 1.0})
    )
    messages = list[str]()
    for make in itertools.islice(SampledPaths().seeds(route_of(problem), (), np.random.default_rng(0)), 12):
        with pytest.raises(NoSeed) as failure:
            make(WorkCounts(), lambda: None)
        messages.append(str(failure.value))
    assert len(messages) == 2 and "nothing new" in messages[-1]


def test_searches_of_many_joints_grow_on(arm: to.Robot) -> None:
    seeds = SampledPaths().seeds(route_of(walled_in(arm)), (), np.random.default_rng(0))
    for make in itertools.islice(seeds, 4):
        with pytest.raises(NoSeed) as failure:
            make(WorkCounts(), lambda: None)
        assert "nothing new" not in str(failure.value)
