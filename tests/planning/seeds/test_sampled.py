"""Paths of the sampling planner: free all along, the same again, within the work allowed."""

import itertools

import numpy as np
import pytest

import trajopt as to
from tests.planning.walls import route_of, wall, walled_in
from tests.robots_for_tests import odd_arm
from trajopt.planning.seeds import NoSeed, SampledPaths, SeedKind
from trajopt.planning.seeds.rrt_connect import _Free, search
from trajopt.planning.seeds.sampled import sampled
from trajopt.query import Counts, Query


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    pytest.importorskip("ompl")
    return odd_arm(tmp_path_factory.mktemp("robot"))


def found(problem: to.Problem, seed: int, checked: int = 20_000) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return sampled(route_of(problem), rng=rng, counts=Counts(), check=lambda: None, checked=checked)


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


def test_it_gives_up_by_count(arm: to.Robot) -> None:
    counts = Counts()
    with pytest.raises(NoSeed, match="500"):
        sampled(
            route_of(walled_in(arm)),
            rng=np.random.default_rng(0),
            counts=counts,
            check=lambda: None,
            checked=500,
        )
    assert counts.forward_kinematics < 3000


def test_what_stops_it_is_raised(arm: to.Robot) -> None:
    class Enough(Exception):
        pass

    def check() -> None:
        raise Enough

    with pytest.raises(Enough):
        sampled(route_of(wall(arm)), rng=np.random.default_rng(0), counts=Counts(), check=check)


def test_path_constraints_are_held_by_projection(arm: to.Robot) -> None:
    problem = wall(arm)
    kept = to.joint_positions({"wrist": 0.0}, tolerance=0.2)
    asked = to.Problem(scene=problem.scene, start=problem.start, goal=problem.goals, constraints=[kept])
    knots = found(asked, 4)
    assert np.abs(knots[:, 3]).max() <= 0.2 + 1e-9
    assert np.abs(found(problem, 4)[:, 3]).max() > 0.2, "without the constraint it turns"


def test_without_the_wheel_the_tries_say_so(arm: to.Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("trajopt.planning.seeds.sampled.find_spec", lambda name: None)
    monkeypatch.setattr("trajopt.planning.search.closed_cut", lambda problem: None)
    result = to.plan(walled_in(arm))
    told = [item for item in result.attempts if item.kind is SeedKind.SAMPLED]
    assert told and all("trajopt-planner[ompl]" in item.message for item in told)
    assert SampledPaths().kind is SeedKind.SAMPLED
    assert result.status is to.Status.STUCK and "clearance" in result.message


def refusing(monkeypatch: pytest.MonkeyPatch, end: np.ndarray) -> None:
    """Let the search call a configuration occupied, whatever is there."""
    asked = _Free.between

    def between(free: _Free, first: np.ndarray, second: np.ndarray) -> bool:
        refused = np.array_equal(first, second) and np.allclose(first, end)
        return not refused and asked(free, first, second)

    monkeypatch.setattr(_Free, "between", between)


@pytest.mark.timeout(60)
@pytest.mark.parametrize(("name", "place"), [("start", 0), ("goal", -1)])
def test_an_end_that_is_taken_to_be_occupied_is_told_at_once(
    arm: to.Robot, monkeypatch: pytest.MonkeyPatch, name: str, place: int
) -> None:
    refusing(monkeypatch, route_of(wall(arm)).line.knots[place])
    with pytest.raises(NoSeed, match=f"takes the {name} to be occupied"):
        found(wall(arm), 1)


@pytest.mark.timeout(60)
def test_a_search_that_looks_at_nothing_more_is_ended(arm: to.Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    refusing(monkeypatch, route_of(wall(arm)).line.knots[-1])
    monkeypatch.setattr(_Free, "raise_what_is_occupied", lambda *ends: None)
    with pytest.raises(NoSeed, match="looked at no more"):
        found(wall(arm), 1)


@pytest.mark.timeout(60)
def test_an_end_a_hair_beyond_a_limit_is_left_and_reached(arm: to.Robot) -> None:
    problem = wall(arm)
    query = Query(problem.reduced, Counts())
    start, goal = route_of(problem).line.knots[[0, -1]]
    limits = query.reduced.limits
    for asked, bound in (((start, goal), limits.lower), ((goal, start), limits.upper)):
        ends = np.array(asked)
        ends[0, 3] = bound[3] + np.sign(bound[3]) * 1e-9
        way = search(
            query,
            *ends,
            scale=route_of(problem).scale,
            rng=np.random.default_rng(3),
            check=lambda: None,
            checked=20_000,
        )
        assert np.allclose(way[[0, -1]], ends, rtol=0.0, atol=1e-12)
