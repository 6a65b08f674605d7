"""What a query remembers: it saves work, and changes no bit of what is found."""

import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
import trajopt.geometry.query
from tests.geometry.test_against_oracle import SHAPES, compare, limits
from tests.oracles.query import PlainQuery
from tests.robots_for_tests import odd_arm
from trajopt.geometry import Contacts, Query
from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.arrays import Floats
from trajopt.values.shapes.shapes import Box, Convex, Shape, convex


def round_body(corners: int, size: float = 0.15) -> Convex:
    directions = np.random.default_rng(corners).normal(size=(corners, 3))
    return convex(size * directions / np.linalg.norm(directions, axis=1)[:, None])


def studded_box() -> Convex:
    """A box whose faces carry many corners that stick out by less than distances are measured to."""
    grid = np.linspace(-1.0, 1.0, 7)
    faces = [np.insert(both, axis, side) for axis in range(3) for side in (-1.0, 1.0)
             for both in np.array(np.meshgrid(grid, grid)).reshape(2, -1).T]  # fmt: skip
    points = np.array(faces)
    return convex(
        np.array([0.2, 0.15, 0.1]) * points * (1.0 + 1e-7 * (3.0 - (points**2).sum(axis=1))[:, None])
    )


def among(folder: Path, shapes: list[Shape], seed: int = 0) -> ReducedModel:
    rng = np.random.default_rng(seed)
    robot = odd_arm(folder)
    scene = to.Scene(robot)
    for count, shape in enumerate(shapes):
        where = to.placement(rng.uniform(-0.7, 0.7, 3), rpy=rng.uniform(-3, 3, 3))
        scene = scene.add(f"thing{count}", shape, where)
    held = to.placement((0.1, 0.02, 0.05))
    scene = scene.add("held", round_body(60, 0.05), held, frame="tip", touch_links=["tip", "finger"])
    return reduce_model(scene, "all", robot.positions())


def path_through(reduced: ReducedModel, seed: int, samples: int) -> Floats:
    start, end = np.random.default_rng(seed).uniform(*limits(reduced), (2, 4))
    return np.linspace(start, end, samples)


def rows(found: Contacts) -> list[Floats]:
    order = np.lexsort((found.pair, found.sample))
    return [getattr(found, name)[order] for name in Contacts.__dataclass_fields__]


@pytest.mark.parametrize("corners", [8, 14, 15, 40, 150, 700])
def test_polytopes_of_many_corners(corners: int, tmp_path: Path) -> None:
    reduced = among(tmp_path, [round_body(corners), Box(0.2, 0.3, 0.1), round_body(corners, 0.1)])
    at = np.random.default_rng(1).uniform(*limits(reduced), (60, 4))
    reach = np.full(len(reduced.pairs.margin), 0.2)
    found, plain = Query(reduced).close_pairs(at, reach), PlainQuery(reduced).close_pairs(at, reach)
    assert (found.distance < 0.0).any()
    # Pairs with capsules and cylinders are in it too.
    assert compare(found, plain, reach, exact=False) > 200
    flat = [pair for pair in range(len(reach)) if all(_polytope(reduced, pair))]
    mine, theirs = (np.isin(contacts.pair, flat) for contacts in (found, plain))
    assert mine.sum() == theirs.sum() > 50
    for one, other in zip(_only(found, mine), _only(plain, theirs), strict=True):
        np.testing.assert_allclose(one, other, atol=2e-9)


def _polytope(reduced: ReducedModel, pair: int) -> list[bool]:
    sides = (reduced.pairs.first[pair], reduced.pairs.second[pair])
    return [isinstance(reduced.bodies[side].shape, Box | Convex) for side in sides]


def _only(found: Contacts, kept: np.ndarray) -> list[Floats]:
    order = np.lexsort((found.pair[kept], found.sample[kept]))
    return [getattr(found, name)[kept][order] for name in ("sample", "pair", "distance")]


def test_corners_that_hardly_stick_out(tmp_path: Path) -> None:
    reduced = among(tmp_path, [studded_box(), studded_box()], seed=3)
    at = np.random.default_rng(2).uniform(*limits(reduced), (80, 4))
    reach = np.full(len(reduced.pairs.margin), 0.3)
    found, plain = Query(reduced).close_pairs(at, reach), PlainQuery(reduced).close_pairs(at, reach)
    assert compare(found, plain, reach, exact=False) > 100


def test_results_do_not_depend_on_earlier_queries(tmp_path: Path) -> None:
    """Coarse and fine samples, steps of all sizes, and reaches that take turns."""
    shapes = [*SHAPES.values(), Box(0.4, 0.02, 0.3), round_body(150), round_body(30)]
    reduced = among(tmp_path, shapes, seed=4)
    rng, asked = np.random.default_rng(5), Query(reduced)
    narrow = reduced.pairs.margin + 0.03
    wide = narrow + rng.uniform(0.0, 0.3, len(narrow))
    count = 0
    motions = {samples: path_through(reduced, 6, samples) for samples in (23, 61)}
    for samples in (23, 23, 61, 61, 23, 61):
        for size in (0.2, 0.02, 0.002, 0.0):
            bump = size * rng.normal(size=4) * np.sin(np.linspace(0.0, np.pi, samples))[:, None]
            motions[samples] = np.clip(motions[samples] + bump, *limits(reduced))
            for reach in (narrow, wide, narrow) if size < 0.02 else (narrow,):
                found = rows(asked.close_pairs(motions[samples], reach))
                fresh = rows(Query(reduced).close_pairs(motions[samples], reach))
                count += len(fresh[0])
                for one, other in zip(found, fresh, strict=True):
                    assert np.array_equal(one, other)
    assert count > 2000


def test_far_pairs_stay_far_for_any_reach(tmp_path: Path) -> None:
    """A cost on clearance asks wider than the constraint beside it; neither forgets what the other found."""
    reduced = among(tmp_path, [round_body(40) for _ in range(8)], seed=7)
    query, motion = Query(reduced), path_through(reduced, 8, 40)
    narrow, wide = reduced.pairs.margin + 0.02, reduced.pairs.margin + 0.1
    for reach in (narrow, wide, narrow):
        query.close_pairs(motion, reach)
    for reach in (wide, narrow):
        before = query.counts.bounds, query.counts.distances
        found = query.close_pairs(motion, reach)
        assert query.counts.distances - before[1] == len(found.distance) > 10
        assert query.counts.bounds == before[0]


def test_a_pair_beyond_its_reach_is_not_measured_again(tmp_path: Path) -> None:
    """Boxes cannot tell that a ball is apart from what lies along its flank; a direction can."""
    reduced = among(tmp_path, [round_body(150, 0.25) for _ in range(8)], seed=9)
    query, motion = Query(reduced), path_through(reduced, 10, 40)
    reach = reduced.pairs.margin + 0.02
    found = query.close_pairs(motion, reach)
    measured = query.counts.distances
    assert measured > len(found.distance) + 20
    beyond = 0
    for step in range(1, 6):
        before = query.counts.distances
        found = query.close_pairs(motion + 0.004 * step, reach)
        beyond += query.counts.distances - before - len(found.distance)
    assert beyond < 0.2 * 5 * (measured - len(found.distance))


def test_neighbours_along_the_path_spare_bounds(tmp_path: Path) -> None:
    reduced = among(tmp_path, [round_body(40) for _ in range(12)], seed=11)
    reach = reduced.pairs.margin + 0.02
    bounds: dict[int, int] = {}
    for samples in (50, 800):
        query = Query(reduced)
        query.close_pairs(path_through(reduced, 12, samples), reach)
        bounds[samples] = query.counts.bounds
    assert bounds[800] < 0.7 * 16 * bounds[50]


def test_all_plans_in_a_scene_share_its_cell(monkeypatch: pytest.MonkeyPatch) -> None:
    """Other starts, goals, tries and threads; a scene with one box more is another one."""
    built: list[ReducedModel] = []
    build = trajopt.geometry.query._cell  # pyright: ignore[reportPrivateUsage]

    def counted(reduced: ReducedModel) -> object:
        built.append(reduced)
        return build(reduced)

    monkeypatch.setattr(trajopt.geometry.query, "_cell", counted)
    robot = to.load("planar2")
    scene = to.Scene(robot).add("post", to.Box(0.1, 0.1, 0.1), to.placement((0.9, 0.0, 0.0)))
    group = next(iter(robot.groups))
    joints = robot.group(group).joints

    def planned(turn: float) -> bool:
        start, goal = dict.fromkeys(joints, -turn), dict.fromkeys(joints, turn)
        problem = to.Problem(scene=scene, group=group, start=start, goal=to.joint_positions(goal))
        return to.plan(problem).verified

    assert planned(0.6)
    assert len(built) == 1
    with ThreadPoolExecutor(3) as pool:
        assert all(pool.map(planned, (0.5, 0.7, 0.8)))
    assert len(built) == 1
    scene = scene.add("more", to.Box(0.1, 0.1, 0.1), to.placement((-1.5, 0.0, 0.0)))
    assert planned(0.6)
    assert len(built) == 2


@pytest.mark.parametrize("name", ["convex", "mesh", "cylinder"])
def test_queries_of_one_cell_on_several_threads(name: str, tmp_path: Path) -> None:
    reduced = among(tmp_path, [SHAPES[name], round_body(150), SHAPES[name]], seed=13)
    reach = np.full(len(reduced.pairs.margin), 0.15)

    def measured(seed: int) -> list[Floats]:
        query, motion = Query(reduced), path_through(reduced, seed, 60)
        found = [rows(query.close_pairs(motion + shift, reach)) for shift in (0.0, 0.01, 0.05)]
        return [array for each in found for array in each]

    alone = [measured(seed) for seed in range(8)]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(measured, range(8)))
    for one, other in zip(alone, together, strict=True):
        assert all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))


@pytest.mark.timeout(120)
def test_the_loops_release_the_interpreter(tmp_path: Path) -> None:
    """With no switch of threads but at locks, another runs during a call only if the call lets it."""
    reduced = among(tmp_path, [round_body(150)], seed=14)
    query, dynamics = Query(reduced), DynamicsQuery(reduced)
    at = np.random.default_rng(15).uniform(*limits(reduced), (20_000, 4))
    back, reach = np.ascontiguousarray(at[::-1]), np.full(len(reduced.pairs.margin), 0.1)
    calls: dict[str, Callable[[], object]] = {
        "close_pairs": lambda: query.close_pairs(at, reach),
        "kinematics": lambda: query.kinematics(at),
        "displacement": lambda: query.displacement(at, back),
        "torque": lambda: dynamics.torque(at, at, at),
        "gravity": lambda: dynamics.gravity(at),
    }
    before = sys.getswitchinterval()
    sys.setswitchinterval(1000.0)
    try:
        held = [name for name, call in calls.items() if not any(_runs_beside(call) for _ in range(50))]
    finally:
        sys.setswitchinterval(before)
    assert not held


def _runs_beside(call: Callable[[], object]) -> bool:
    """Say whether this thread ran while another was in a call."""
    begun, ended = threading.Event(), threading.Event()

    def work() -> None:
        begun.set()
        call()
        ended.set()

    worker = threading.Thread(target=work)
    worker.start()
    begun.wait()
    beside = not ended.is_set()
    worker.join()
    return beside


def test_distances_above_the_aim_lose_a_third_of_their_excess_at_most(tmp_path: Path) -> None:
    """Against exact ones of a fresh query: small and large steps, and other samples of the motion."""
    shapes = [*SHAPES.values(), Box(0.4, 0.02, 0.3), round_body(150), round_body(30)]
    reduced = among(tmp_path, shapes, seed=4)
    rng, query = np.random.default_rng(7), Query(reduced)
    aim, pairs = reduced.pairs.margin, len(reduced.pairs.margin)
    reach = aim + 0.05
    inexact = compared = 0
    for samples in (23, 61, 40):
        motion = path_through(reduced, 6, samples)
        for size in (0.1, 0.02, 0.01, 0.001):
            bump = size * rng.normal(size=4) * np.sin(np.linspace(0.0, np.pi, samples))[:, None]
            motion = np.clip(motion + bump, *limits(reduced))
            found, exact = (
                query.close_pairs(motion, reach, aim),
                Query(reduced).close_pairs(motion, 2.0 * reach),
            )
            true = dict(
                zip((exact.sample * pairs + exact.pair).tolist(), exact.distance.tolist(), strict=True)
            )
            asked = dict(
                zip((found.sample * pairs + found.pair).tolist(), found.distance.tolist(), strict=True)
            )
            assert {key for key, distance in true.items() if distance < reach[key % pairs]} <= asked.keys()
            for key, distance in asked.items():
                excess = max(true[key] - aim[key % pairs], 0.0)
                assert true[key] - excess / 3.0 - 1e-8 <= distance <= true[key] + 1e-8
                inexact += abs(distance - true[key]) > 1e-6
                compared += 1
    assert inexact > 50 and compared > 5 * inexact // 10


def test_a_query_that_forgot_is_as_a_fresh_one(tmp_path: Path) -> None:
    reduced = among(tmp_path, [Box(0.4, 0.02, 0.3), round_body(150), round_body(30)], seed=4)
    used, motion = Query(reduced), path_through(reduced, 6, 40)
    aim = reduced.pairs.margin
    used.close_pairs(motion + 0.01, aim + 0.05, aim)
    before = used.counts.distances
    inexact = rows(used.close_pairs(motion, aim + 0.05, aim))
    assert used.counts.distances - before < len(inexact[0])
    used.forget()
    again = rows(used.close_pairs(motion, aim + 0.05, aim))
    for one, other in zip(again, rows(Query(reduced).close_pairs(motion, aim + 0.05, aim)), strict=True):
        assert np.array_equal(one, other)
