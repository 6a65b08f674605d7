"""A motion that the judge refused is timed again nearer to its path, but never the same motion twice."""

from pathlib import Path as FilePath

import numpy as np
import pytest

import trajopt as to
from tests.planning.walls import wall
from tests.robots_for_tests import odd_arm
from trajopt.optimise.methods import Decoded
from trajopt.planning.budget import Budget, BudgetTracker
from trajopt.planning.workspace import MotionCandidate, PlanningWorkspace
from trajopt.values.trajectory import Path


@pytest.fixture
def problem(tmp_path: FilePath) -> to.Problem:
    return wall(odd_arm(tmp_path), inner_edge=1.5)


def motions(problem: to.Problem, knots: list[list[float]], *, narrow: bool = False) -> list[MotionCandidate]:
    path = Path(problem.reduced.joint_names, np.array(knots))
    work = PlanningWorkspace(problem, BudgetTracker(Budget()))
    made = list(work.timed((Decoded(path, narrow=narrow),)))
    assert all(isinstance(motion, MotionCandidate) for motion in made)
    return [motion for motion in made if isinstance(motion, MotionCandidate)]


def test_a_straight_motion_is_made_once(problem: to.Problem) -> None:
    start = problem.reduced.start_positions.tolist()
    knots = [start, [each + 0.2 for each in start]]
    (only,) = motions(problem, knots, narrow=True)
    assert only.timed is not None
    assert only.timed.deviation <= 1e-9


def test_a_corner_is_rounded_less_each_time(problem: to.Problem) -> None:
    start = problem.reduced.start_positions
    turn = start + np.array((0.3, 0.0, 0.0, 0.0))
    knots = [start.tolist(), turn.tolist(), (turn + np.array((0.0, 0.1, 0.3, 0.0))).tolist()]
    made = motions(problem, knots, narrow=True)
    away = [motion.timed.deviation for motion in made if motion.timed is not None]
    assert len(away) == 3
    assert away[0] > 1e-3 >= away[1] > 1e-4 >= away[2] > 0.0
