"""The schedule is a table: what is tried, in which order, how many of each."""

from dataclasses import replace
from itertools import islice, pairwise
from pathlib import Path

import numpy as np

import trajopt as to
from tests.planning.walls import wall
from tests.robots_for_tests import odd_arm
from trajopt.files.moveit import read_request, read_scene
from trajopt.optimise.solvers import Effort, SolverStatus
from trajopt.optimise.transcription import fixed_goal
from trajopt.planning.goal_search import ALIKE, BRANCHES, several
from trajopt.planning.schedule import CYCLE, CYCLES, OPENING, rounds
from trajopt.planning.seeds import SeedKind


def test_the_straight_line_to_the_nearest_goal_comes_first_and_alone() -> None:
    (row,) = OPENING[0]
    assert row.source is SeedKind.STRAIGHT and row.branches == (0, 1) and row.effort is Effort.TENTATIVE


def test_every_branch_gets_its_straight_line_once() -> None:
    straight = [row.branches for rows in OPENING for row in rows if row.source is SeedKind.STRAIGHT]
    assert straight[0][0] == 0 and straight[-1][1] is None
    assert all(before[1] == after[0] for before, after in pairwise(straight))


def test_the_next_round_continues_brief_attempts() -> None:
    for table in (OPENING, CYCLE):
        for rows, following in pairwise(table):
            if any(row.effort is Effort.BRIEF for row in rows):
                assert [row.source for row in following] == [None]


def test_straight_lines_are_given_up_early_and_sampled_paths_never() -> None:
    efforts = {SeedKind.STRAIGHT: Effort.TENTATIVE, SeedKind.SAMPLED: Effort.FULL, None: Effort.FULL}
    for row in (row for rows in (*OPENING, *CYCLE) for row in rows):
        assert row.effort is efforts.get(row.source, Effort.BRIEF)


def test_rounds_end_without_a_budget_and_go_on_with_one() -> None:
    whole = list(rounds(bounded=False))
    assert len(whole) == len(OPENING) + CYCLES * len(CYCLE)
    assert list(islice(rounds(bounded=True), len(whole) + 1)) == [*whole, CYCLE[0]]


def test_every_endless_row_is_counted() -> None:
    assert all(row.count is not None for rows in CYCLE for row in rows)


def test_a_line_is_given_up_if_another_seed_may_follow(tmp_path: Path) -> None:
    problem = wall(odd_arm(tmp_path))
    for attempts, ended in ((1, SolverStatus.MAX_ITERATIONS), (2, SolverStatus.GIVEN_UP)):
        first = to.plan(problem, budget=to.Budget(attempts=attempts)).attempts[0]
        assert first.kind is SeedKind.STRAIGHT and first.solver is ended


def test_goal_configurations_on_the_other_side_are_tried_too() -> None:
    """Before, the twelve nearest were tried, and all those of a Jaco arm were behind a box."""
    near = [np.array((0.01 * k, 0.0)) for k in range(40)]
    other = [np.array((3.0, 0.1 * k)) for k in range(10)]
    chosen = several([*near, *other], np.ones(2))
    assert len(chosen) == BRANCHES
    assert all(each is one for each, one in zip(chosen[:ALIKE], near, strict=False))
    assert sum(each[0] == 3.0 for each in chosen) >= 2
    assert several(other[:3], np.ones(2)) == other[:3]


def test_goal_configurations_are_searched_again_if_no_path_leads_to_those_found(shared_data: Path) -> None:
    """Before, one configuration was found, and it is proven that no path leads to it."""
    folder = shared_data / "motionbenchmaker" / "ur5"
    robot = to.load(folder / "robot" / "ur5.urdf", srdf=folder / "robot" / "ur5.srdf")
    scene = read_scene(folder / "table_pick" / "scene0007.yaml", robot)
    asked = read_request(folder / "table_pick" / "request0007.yaml", scene).problem()
    end = fixed_goal(asked)
    assert end is not None
    where = asked.scene.placement_of("ee_link", asked.reduced.all_positions(end))
    point = to.frame_placement("ee_link", where, rotation_tolerance=np.inf)
    assert len(to.goal_configurations(replace(asked, goal=point))) == 1
    assert to.plan(replace(asked, goal=point)).verified
