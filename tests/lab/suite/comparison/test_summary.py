"""Sums over runs, the performance profile and the tables, on runs with known numbers."""

from dataclasses import replace

import numpy as np
import pytest

from tests.lab.suite.comparison.runs_for_tests import ALL, FAILED, FAST, UNASKABLE
from tests.lab.suite.suite.outcomes import BROKEN
from trajopt.lab.suite.outcome import performance_profile, summaries
from trajopt.lab.suite.pages import RUN_HEAD, SUMMARY_HEAD, markdown, run_cells, summary_cells
from trajopt.planning.status import Certainty, Status


def test_summaries() -> None:
    sqp, chomp = summaries(ALL)
    assert (sqp.solver, sqp.good, sqp.total) == ("sqp", 3, 3)
    assert (chomp.solver, chomp.good, chomp.total) == ("chomp", 2, 3)
    assert sqp.groups == {"installed": (2, 2), "box": (1, 1)}
    assert chomp.groups == {"installed": (2, 2), "box": (0, 1)}
    assert sqp.cpu_median == pytest.approx(0.15) and chomp.cpu_median == pytest.approx(0.4)
    assert sqp.cost == 1.0 and chomp.cost == pytest.approx(1.5)
    assert chomp.duration == pytest.approx(1.1) and chomp.path_length == pytest.approx(1.1)
    assert chomp.clearance == 0.0123


def test_profile() -> None:
    profile = performance_profile(ALL)
    assert profile["sqp"] == pytest.approx([1.0, 1.0])
    assert profile["chomp"] == pytest.approx([4.0, np.inf])


def test_a_problem_without_any_solution_counts_in_the_profile() -> None:
    assert performance_profile([FAILED])["chomp"] == pytest.approx([np.inf])


def test_tables() -> None:
    assert all(len(run_cells(run)) == len(RUN_HEAD) for run in ALL)
    assert all(len(summary_cells(item)) == len(SUMMARY_HEAD) for item in summaries(ALL))
    assert "clearance by 0.04" in run_cells(FAILED) and "12.3" in run_cells(FAST)
    text = markdown(ALL)
    assert "| sqp | 3 of 3 |" in text and "| chomp | 2/2 | 0/1 |" in text
    assert "- **chomp** (1): box/1 (STUCK)" in text and "- **sqp** (0): none" in text


def test_only_proven_problems_leave_the_count() -> None:
    guessed = replace(UNASKABLE, certainty=Certainty.EVIDENCE)
    cannot = replace(UNASKABLE, status=Status.METHOD_CANNOT)
    assert not UNASKABLE.askable and guessed.askable and cannot.askable
    (sqp,) = summaries((UNASKABLE, guessed, cannot, FAST))
    assert (sqp.good, sqp.total) == (1, 3)


def test_a_motion_refused_by_a_fresh_judge_is_not_a_success() -> None:
    broken = replace(FAST, constraints=(BROKEN,))
    assert broken.status is Status.SOLVED and broken.askable
    assert not broken.verified and not broken.good
