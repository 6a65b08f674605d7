"""Paths searched: clear by plain Coal, the same for a seed, ended by count and from outside."""

import itertools
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import example, given

import trajopt as to
from tests.oracles.query import PlainQuery
from tests.robots_for_tests import odd_arm
from trajopt.geometry import Query, SearchSpace, WorkCounts, search_path
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.arrays import Floats
from trajopt.values.shapes.shapes import Box

STEP = 0.03


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    return odd_arm(tmp_path_factory.mktemp("robot"))


def ends_of(reduced: ReducedModel) -> tuple[Floats, Floats]:
    """Return where joints are searched."""
    return np.maximum(reduced.limits.lower, -np.pi), np.minimum(reduced.limits.upper, np.pi)


def space(reduced: ReducedModel, reach: Floats) -> SearchSpace:
    lower, upper = ends_of(reduced)
    return SearchSpace(lower, upper, np.array([0.5, 0.2, 0.7, 1.0]), reach, STEP)


def searched(
    reduced: ReducedModel, start: Floats, goals: Floats, seed: int, checked: int = 20_000
) -> tuple[Floats | None, WorkCounts]:
    query = Query(reduced)
    found = search_path(
        query,
        start,
        goals,
        space(reduced, reduced.pairs.margin),
        checked=checked,
        shortening=2000,
        seed=seed,
        check=lambda: None,
    )
    return found.corners, query.counts


def dense(corners: Floats) -> Floats:
    return np.concatenate([np.linspace(a, b, 50) for a, b in itertools.pairwise(corners)])


def wall(arm: to.Robot, window: float) -> ReducedModel:
    """Return the arm behind a wall across its whole reach, with a window [m] to swing through."""
    scene = to.Scene(arm)
    low = scene.add("low", Box(1.5, 0.02, 2.0), to.placement((0.85, 0.0, 0.45 - window / 2 - 1.0)))
    both = low.add("high", Box(1.5, 0.02, 2.0), to.placement((0.85, 0.0, 0.45 + window / 2 + 1.0)))
    back = both.add("back", Box(1.5, 0.02, 3.0), to.placement((-0.85, 0.0, 0.0)))
    return reduce_model(back, "all", arm.positions())


START, GOAL = np.array([-1.0, 0.1, 0.3, 0.0]), np.array([1.0, 0.1, 0.3, 0.0])


@given(st.integers(0, 2**32))
@example(7525)
def test_found_paths_are_clear_in_small_worlds(number: int) -> None:
    rng = np.random.default_rng(number)
    with TemporaryDirectory() as folder:
        scene = to.Scene(odd_arm(Path(folder)))
        for count in range(4):
            where = to.placement(rng.uniform(-0.9, 0.9, 3), rpy=rng.uniform(-3, 3, 3))
            scene = scene.add(f"box{count}", Box(*rng.uniform(0.05, 0.4, 3)), where)
        reduced = reduce_model(scene, "all", scene.robot.positions())
    reach, plain = reduced.pairs.margin, PlainQuery(reduced)
    drawn = rng.uniform(*ends_of(reduced), size=(60, 4))
    near = set(plain.close_pairs(drawn, reach).sample.tolist())
    free = [row for count, row in enumerate(drawn) if count not in near]
    if len(free) < 4:
        return
    corners, _ = searched(reduced, free[0], np.array(free[1:4]), seed=number, checked=3000)
    if corners is None:
        return
    assert np.array_equal(corners[0], free[0])
    assert any(np.array_equal(corners[-1], goal) for goal in free[1:4])
    lower, upper = ends_of(reduced)
    assert (corners >= lower - 1e-12).all() and (corners <= upper + 1e-12).all()
    assert not len(plain.close_pairs(corners, reach).pair), "corners keep the whole reach"
    # Between two checks nothing moves farther than a step, so nothing comes nearer by more than half of it.
    assert not len(plain.close_pairs(dense(corners), reach - 0.5 * STEP).pair)


def test_a_window_is_found_and_gone_through(arm: to.Robot) -> None:
    reduced = wall(arm, 0.3)
    found, counts = searched(reduced, START, GOAL[None], seed=1)
    assert found is not None and len(found) > 2
    assert counts.forward_kinematics > 50 and counts.distances > 0 and counts.bounds > 0
    assert np.abs(np.diff(np.sign(found[:, 0]))).sum() == 2, "once through the wall"


def test_without_a_window_it_ends_at_its_count(arm: to.Robot) -> None:
    found, counts = searched(wall(arm, 0.0), START, GOAL[None], seed=1, checked=700)
    assert found is None and 700 <= counts.forward_kinematics < 1500


def test_an_occupied_end_is_not_reached(arm: to.Robot) -> None:
    inside = np.array([0.0, 0.3, 0.0, 0.0])
    reduced = wall(arm, 0.1)
    assert len(PlainQuery(reduced).close_pairs(inside[None], reduced.pairs.required).pair)
    for start, goal in ((START, inside), (inside, GOAL)):
        found, _ = searched(reduced, start, goal[None], seed=3, checked=500)
        assert found is None


def test_of_several_goals_one_that_can_be_reached_is(arm: to.Robot) -> None:
    beyond, here = GOAL, np.array([-2.0, 0.2, 0.5, 1.0])
    found, _ = searched(wall(arm, 0.0), START, np.array([beyond, here]), seed=0)
    assert found is not None and np.array_equal(found[-1], here)


def test_the_seed_determines_the_search(arm: to.Robot) -> None:
    reduced = wall(arm, 0.3)
    (first, counted), (again, recounted) = (searched(reduced, START, GOAL[None], seed=5) for _ in range(2))
    assert first is not None and again is not None and np.array_equal(first, again)
    assert vars(counted) == vars(recounted)
    other, _ = searched(reduced, START, GOAL[None], seed=6)
    assert other is None or not np.array_equal(first, other)


def test_threads_do_not_disturb_each_other(arm: to.Robot) -> None:
    reduced, found = wall(arm, 0.3), dict[int, Floats | None]()

    def run(seed: int) -> None:
        found[seed] = searched(reduced, START, GOAL[None], seed)[0]

    threads = [Thread(target=run, args=(seed,)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for seed, corners in found.items():
        alone, _ = searched(reduced, START, GOAL[None], seed)
        assert (alone is None) == (corners is None)
        assert alone is None or np.array_equal(alone, corners)


@pytest.mark.timeout(60)
def test_an_exception_of_the_callback_ends_the_search(arm: to.Robot) -> None:
    class Enough(Exception):
        pass

    asked: list[int] = []
    query = Query(wall(arm, 0.0))

    def check() -> None:
        asked.append(query.counts.forward_kinematics)
        if len(asked) == 3:
            raise Enough

    with pytest.raises(Enough):
        search_path(
            query,
            START,
            GOAL[None],
            space(query.reduced, query.reduced.pairs.margin),
            checked=10**12,
            shortening=0,
            seed=0,
            check=check,
        )
    assert asked == sorted(asked) and asked[-1] < 3000


def test_bodies_may_overlap_by_as_much_as_the_reach_allows(arm: to.Robot) -> None:
    reduced = wall(arm, 0.0)
    query, plain = Query(reduced), PlainQuery(reduced)
    touching = np.array([[0.03, 0.1, 0.3, 0.0], [0.2, 0.1, 0.3, 0.0], [0.4, 0.1, 0.3, 0.0]])
    for depth in (0.0, 0.02, 0.1):
        reach = np.full(len(reduced.pairs.margin), -depth)
        for goal in touching:
            found = search_path(
                query,
                GOAL,
                goal[None],
                space(reduced, reach),
                checked=1,
                shortening=0,
                seed=0,
                check=lambda: None,
            ).corners
            near = plain.close_pairs(np.linspace(GOAL, goal, 200), reach)
            if not len(near.pair):
                assert found is not None
            elif len(plain.close_pairs(goal[None], reach).pair):
                assert found is None
