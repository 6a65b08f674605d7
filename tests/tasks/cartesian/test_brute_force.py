"""Random lines of the Panda: whatever a flood over all self-motions can follow, is followed."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

import trajopt as to
from trajopt.geometry import Query
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.tasks.cartesian import Curve, FollowsCurve, follow, follows_curve, line
from trajopt.tasks.cartesian.tracking import OnCurve
from trajopt.values.arrays import Floats

TCP = "panda_hand_tcp"
STATIONS = 31
SPACING = 0.12
"""Of configurations along the self-motion of a place [rad]."""
SAME = 0.06


@cache
def panda() -> to.Robot:
    return to.load("panda")


class Flood:
    """All configurations of a place that are reached without a jump from those of the place before."""

    def __init__(self, reduced: ReducedModel, required: FollowsCurve) -> None:
        self.reduced, self.query = reduced, Query(reduced)
        self.on_curve = OnCurve(reduced, required, self.query)

    def reaches(self, stations: Floats) -> float:
        """How far along the curve some of them get."""
        found = self._spread(self.reduced.start_positions[None], float(stations[0]))
        for before, s in pairwise(stations.tolist()):
            moved = self.on_curve(found, np.full(len(found), s))
            small = np.abs(moved.positions - found).max(axis=1) < 0.3
            found = self._spread(self._clear(moved.positions[moved.held & small]), s)
            if len(found) == 0:
                return before
        return float(stations[-1])

    def _clear(self, q: Floats) -> Floats:
        if len(q) == 0:
            return q
        touching = self.query.close_pairs(q, self.reduced.pairs.margin)
        return np.delete(q, np.unique(touching.sample), axis=0)

    def _spread(self, seeds: Floats, s: float) -> Floats:
        """Walk along the self-motion both ways, from all seeds, to the limits."""
        kept = np.empty((0, 7))
        front = self._new(seeds, kept)
        while len(front) and len(kept) < 500:
            kept = np.concatenate((kept, front))
            _, jacobian = self.on_curve.errors(front, np.full(len(front), s))
            along = np.linalg.svd(jacobian)[2][:, -1]
            tried = np.concatenate((front + SPACING * along, front - SPACING * along))
            moved = self.on_curve(tried, np.full(len(tried), s))
            near = np.abs(moved.positions - tried).max(axis=1) < 0.5 * SPACING
            front = self._new(self._clear(moved.positions[moved.held & near]), kept)
        return kept

    def _new(self, q: Floats, kept: Floats) -> Floats:
        found: list[Floats] = []
        for row in q:
            others = np.array([*kept, *found]).reshape(-1, 7)
            if not (np.abs(others - row).max(axis=1) < SAME).any():
                found.append(row)
        return np.array(found).reshape(-1, 7)


def random_line(rng: np.random.Generator, scene: to.Scene) -> tuple[Floats, Curve]:
    """A clear start, and a line of up to 60 cm that turns by up to a radian."""
    robot = panda()
    limits = robot.limits.take(robot.index(robot.group("panda_arm").joints))
    while True:
        arm = dict(zip(limits.joint_names, rng.uniform(limits.lower, limits.upper), strict=True))
        start = robot.positions({**robot.state("ready"), **arm})
        reduced = reduce_model(scene, "panda_arm", start)
        begin = scene.placement_of(TCP, start)
        clear = (
            len(Query(reduced).close_pairs(reduced.start_positions[None], reduced.pairs.margin).distance) == 0
        )
        if not clear or begin.translation[2] < 0.1:
            continue
        goal = begin.translation + rng.uniform(-0.35, 0.35, 3)
        if 0.25 < np.linalg.norm(goal) < 0.75 and goal[2] > 0.05:
            turn = to.placement(rpy=rng.uniform(-0.6, 0.6, 3)).rotation
            return start, line(begin, to.placement(goal, rotation=begin.rotation @ turn))


def compare(seed: int) -> tuple[float, float]:
    """Return the fractions that are followed, and that the flood can follow."""
    scene = to.Scene(panda())
    start, way = random_line(np.random.default_rng(seed), scene)
    required = follows_curve(TCP, way)
    result = follow(scene, required, start=start, group="panda_arm")
    if result.stop is not None:
        assert result.fraction == 0.0 or result.verified, result.explain()
    flood = Flood(reduce_model(scene, "panda_arm", start), required)
    return result.fraction, flood.reaches(np.linspace(0.0, way.length, STATIONS)) / way.length


@pytest.mark.parametrize("seed", range(3))
def test_some_random_lines(seed: int) -> None:
    got, possible = compare(seed)
    assert got >= possible - 1.5 / STATIONS


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 130))
def test_random_lines(seed: int) -> None:
    got, possible = compare(seed)
    assert got >= possible - 1.5 / STATIONS
