"""A bundle planned anew gives the same answer, or says what differs."""

from dataclasses import replace
from importlib.metadata import entry_points
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.files.bundle import read_bundle, replay, save
from trajopt.optimise.methods.bspline import Bspline
from trajopt.planning import Result
from trajopt.problem.problem import named_problem
from trajopt.values.errors import ModelError

FIXTURE = Path(__file__).parent / "past_a_ball_v1.trajopt"
"""Written by the first version of the format."""


def test_the_same_version_gives_the_same_answer(kept: Path) -> None:
    found = replay(read_bundle(kept))
    assert found.same, found.differences
    assert "the same answer" in str(found)


def test_a_bundle_of_the_first_version_is_read(solved: Result) -> None:
    bundle = read_bundle(FIXTURE)
    assert bundle.judged().verified
    assert bundle.problem.name == solved.problem.name
    assert replay(bundle).result.verified


def test_a_replay_repeats_the_arguments(solved: Result, tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    rng.random(3)
    result = to.plan(solved.problem, method="bspline", rng=rng, budget=to.Budget(attempts=3))
    result.save(tmp_path / "arguments.trajopt")
    bundle = read_bundle(tmp_path / "arguments.trajopt")
    arguments = bundle.arguments
    assert arguments is not None and arguments.method == "bspline" and arguments.budget.attempts == 3
    assert arguments.generator is not None
    fresh = np.random.default_rng(5)
    fresh.random(3)
    assert arguments.generator.random() == fresh.random()
    assert replay(bundle).same


def test_a_replay_reports_differences(kept: Path) -> None:
    bundle = read_bundle(kept)
    other = replay(bundle, method="chomp")
    assert not other.same
    assert any(words.startswith("motion: ") for words in other.differences)
    older = replace(bundle, versions={**bundle.versions, "numpy": "1.0"}, trajectory=None)
    said = replay(older).differences
    assert "motion: none then, one now" in said
    assert any("numpy 1.0 then" in words for words in said)


def test_a_method_of_ones_own_is_given_again(solved: Result, tmp_path: Path) -> None:
    method = Bspline(pieces=9)
    to.plan(solved.problem, method=method).save(tmp_path / "own.trajopt")
    bundle = read_bundle(tmp_path / "own.trajopt")
    with pytest.raises(ModelError, match="options of its own"):
        replay(bundle)
    assert replay(bundle, method=method).same


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_fifty_bundles_are_replayed_to_the_last_digit(tmp_path: Path) -> None:
    names = sorted(entry.name for entry in entry_points(group="trajopt.problems"))[:50]
    assert len(names) == 50
    for name in names:
        to.plan(named_problem(name)).save(
            tmp_path / "one.trajopt",
        )
        found = replay(read_bundle(tmp_path / "one.trajopt"))
        assert found.same, (name, found.differences)


def test_a_problem_that_was_never_planned_is_planned(solved: Result, tmp_path: Path) -> None:
    save(solved.problem, tmp_path / "problem.trajopt")
    assert replay(read_bundle(tmp_path / "problem.trajopt")).result.verified


def test_paths_that_were_given_are_given_again(solved: Result, tmp_path: Path) -> None:
    again = to.plan(solved.problem, seeds=[solved.require().path])
    again.save(tmp_path / "given.trajopt")
    found = replay(read_bundle(tmp_path / "given.trajopt"))
    assert found.same, found.differences
    assert found.result.attempts[0].kind is again.attempts[0].kind
