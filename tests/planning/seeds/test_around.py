"""Lines bent around what blocked: the touching point is where it was asked to be, the ends stay."""

import numpy as np
import pytest

import trajopt as to
from tests.planning.walls import blocked_by, route_of, wall
from tests.robots_for_tests import odd_arm
from trajopt.geometry import Query, WorkCounts
from trajopt.planning.seeds import DetourLines, NoSeed, SeedKind
from trajopt.planning.seeds.lines import SIDES, SIZES, bent


@pytest.fixture(scope="module")
def problem(tmp_path_factory: pytest.TempPathFactory) -> to.Problem:
    return wall(odd_arm(tmp_path_factory.mktemp("robot")))


def test_every_side_moves_the_touching_body_there_and_keeps_the_ends(problem: to.Problem) -> None:
    context, blocked = route_of(problem), blocked_by(problem, "wall")
    line, middle = context.line.knots, (problem.knots - 1) // 2
    limits = problem.reduced.limits
    reach = np.full(len(problem.reduced.pairs.margin), -np.inf)
    reach[blocked.pair] = 1.0
    here = Query(problem.reduced).close_pairs(0.5 * (line[middle] + line[middle + 1])[None], reach)
    shifts = []
    for side in range(SIDES):
        knots = bent(context, blocked, side, 0.1, counts=WorkCounts())
        assert np.array_equal(knots[[0, -1]], line[[0, -1]])
        assert (knots >= limits.lower).all() and (knots <= limits.upper).all()
        assert np.abs(np.diff(knots - line, axis=0)).max() < 0.5, "it bends softly"
        peak = 0.5 * (knots[middle] + knots[middle + 1])
        before, after = (
            problem.scene.placement_of("tip", problem.reduced.all_positions(q)).translation
            for q in (0.5 * (line[middle] + line[middle + 1]), peak)
        )
        shifts.append(after - before)
    directions = np.array(shifts)
    assert (np.linalg.norm(directions, axis=1) > 0.02).all()
    assert directions[0] @ directions[1:].T == pytest.approx(directions[0] @ directions[1:].T)
    push = here.normal[0] * (1.0 if problem.reduced.owners(blocked.pair)[1] == "tip" else -1.0)
    assert np.argmax(directions @ push) == 0, "first the side that the contact pushes to"


def test_all_sides_and_sizes_of_each_blocked_try(problem: to.Problem) -> None:
    blocked, rng = blocked_by(problem, "wall"), np.random.default_rng(0)
    assert len(list(DetourLines().seeds(route_of(problem), (blocked,), rng))) == SIDES * len(SIZES)
    assert list(DetourLines().seeds(route_of(problem), (), rng)) == []
    assert DetourLines().kind is SeedKind.AROUND


def test_a_distant_obstacle_gives_no_seed(problem: to.Problem) -> None:
    away = wall(problem.scene.robot, inner_edge=3.0)
    with pytest.raises(NoSeed, match="pair is not close"):
        bent(route_of(away), blocked_by(away, "wall"), 0, 0.1, counts=WorkCounts())
