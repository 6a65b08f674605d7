"""plan_many: each result as if planned alone, in order, from any number of threads."""

from collections.abc import Iterator
from functools import partial
from itertools import islice
from threading import Event, Thread
from threading import enumerate as enumerate_threads

import numpy as np
import pytest

import trajopt as to
from tests.planning.walls import wall
from tests.robots_for_tests import odd_arm
from trajopt.values.errors import ProblemError


@pytest.fixture(scope="module")
def problems(tmp_path_factory: pytest.TempPathFactory) -> list[to.Problem]:
    arm = odd_arm(tmp_path_factory.mktemp("robot"))
    return [wall(arm, edge) for edge in (0.5, 0.53, 0.55, 0.58, 0.6)]


def helpers() -> list[Thread]:
    return [thread for thread in enumerate_threads() if thread.name.startswith("trajopt")]


@pytest.mark.parametrize("workers", [1, 2, 4])
def test_each_is_planned_as_if_alone(problems: list[to.Problem], workers: int) -> None:
    together = list(to.plan_many(problems, workers=workers, bar=False))
    for problem, result in zip(problems, together, strict=True):
        alone = to.plan(problem)
        assert result.problem is problem
        assert result.attempts == alone.attempts and result.counts == alone.counts
        assert np.array_equal(result.require().trajectory.positions, alone.require().trajectory.positions)


def test_options_go_to_the_planner(problems: list[to.Problem]) -> None:
    planner = partial(to.plan, method="chomp", budget=to.Budget(attempts=1))
    (result,) = to.plan_many(problems[:1], planner=planner, bar=False)
    assert len(result.attempts) == 1


def test_problems_may_come_without_end_and_the_iteration_may_end_early(problems: list[to.Problem]) -> None:
    taken: list[int] = []

    def without_end() -> Iterator[to.Problem]:
        while True:
            taken.append(len(taken))
            yield problems[len(taken) % 2]

    results = to.plan_many(without_end(), workers=2, bar=False)
    assert len(list(islice(results, 3))) == 3
    assert isinstance(results, Iterator)
    del results
    assert len(taken) <= 3 + 2 * 2 + 1
    assert not helpers()


def test_unneeded_plans_are_cancelled(problems: list[to.Problem]) -> None:
    cancelled = Event()

    def waiting(problem: to.Problem, *, cancel: Event | None = None) -> to.Result:
        assert cancel is not None
        if problem is not problems[0]:
            assert cancel.wait(60.0)
            cancelled.set()
        return to.plan(problem)

    for result in to.plan_many(problems[:2], workers=2, planner=waiting, bar=False):
        assert result.verified
        break
    assert cancelled.wait(60.0) and not helpers()


def test_an_error_is_raised_at_its_turn(problems: list[to.Problem]) -> None:
    with pytest.raises(ProblemError, match="each of problems must be a Problem, is 'no problem'"):
        to.plan_many([problems[0], "no problem"])  # pyright: ignore[reportArgumentType]
    generated = (each for each in (problems[0], "no problem"))
    results = to.plan_many(generated, workers=2, bar=False)  # pyright: ignore[reportArgumentType]
    assert next(results).verified
    with pytest.raises(ProblemError, match="each of problems must be a Problem, is 'no problem'"):
        next(results)
    assert not helpers()


@pytest.mark.parametrize("workers", [0, -1, 1.5, "two"])
def test_workers_are_counted(problems: list[to.Problem], workers: int) -> None:
    with pytest.raises(ProblemError, match="workers must be a"):
        to.plan_many(problems, workers=workers)


def test_without_problems_there_are_no_results() -> None:
    assert list(to.plan_many([])) == []


def test_the_bar_is_shown_on_a_terminal_only(
    problems: list[to.Problem], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    list(to.plan_many(problems[:1]))
    assert capfd.readouterr().err == ""
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    list(to.plan_many(problems[:1]))
    assert "1/1" in capfd.readouterr().err
