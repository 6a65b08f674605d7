"""Several processes: the same answer as one, and a death among them is told."""

import os
import signal
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from threading import Event, Thread

import numpy as np
import pytest

import trajopt as to
from tests.planning.walls import wall, walled_in
from tests.robots_for_tests import odd_arm
from trajopt.methods import Decoded, Knots, Program
from trajopt.planning.budget import Stop
from trajopt.planning.seeds import SeedKind
from trajopt.planning.status import Status
from trajopt.planning.workers import start_context
from trajopt.query import Counts
from trajopt.solvers import Iteration, SolveResult

HERE = os.getpid()
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    return odd_arm(tmp_path_factory.mktemp("robot"))


@pytest.mark.parametrize("inner_edge", [0.5, 0.55])
def test_the_answer_is_the_same_with_any_number_of_workers(arm: to.Robot, inner_edge: float) -> None:
    alone = to.plan(wall(arm, inner_edge), rng=np.random.default_rng(3))
    several = to.plan(wall(arm, inner_edge), rng=np.random.default_rng(3), budget=to.Budget(workers=3))
    _same(alone, several)
    assert len(alone.attempts) > 1, "from the second on they are made in processes"
    assert alone.counts["qp_solves"] == several.counts["qp_solves"]


def test_the_answer_is_the_same_from_spawned_workers(arm: to.Robot) -> None:
    alone = to.plan(wall(arm), rng=np.random.default_rng(3))
    budget = to.Budget(workers=2, processes=get_context("spawn"))
    several = to.plan(wall(arm), rng=np.random.default_rng(3), budget=budget)
    _same(alone, several)
    assert len(alone.attempts) > 1, "from the second on they are made in processes"
    assert alone.counts["qp_solves"] == several.counts["qp_solves"]


def test_what_cannot_be_sent_is_refused(arm: to.Robot) -> None:
    budget = to.Budget(workers=2, seconds=100.0, clock=lambda: 0.0, processes=get_context("spawn"))
    with pytest.raises(to.TrajoptError, match="must be picklable"):
        to.plan(wall(arm), budget=budget)


def test_several_threads_are_not_forked() -> None:
    chosen = get_context("spawn")
    assert start_context(chosen) is chosen
    done = Event()
    other = Thread(target=done.wait)
    other.start()
    try:
        assert start_context(None).get_start_method() != "fork"
    finally:
        done.set()
        other.join()


def test_so_is_an_improved_one(arm: to.Robot) -> None:
    one, three = (
        to.plan(wall(arm), budget=to.Budget(attempts=17, improve=True, workers=workers)) for workers in (1, 3)
    )
    _same(one, three)
    assert len(one.attempts) == 17


def test_so_is_one_that_ran_out_of_work(arm: to.Robot) -> None:
    work = to.plan(wall(arm)).counts["forward_kinematics"] - 1
    one, three = (to.plan(wall(arm), budget=to.Budget(work=work, workers=workers)) for workers in (1, 3))
    assert one.status is three.status is Status.OUT_OF_WORK
    assert one.attempts == three.attempts


def _same(one: to.Result, other: to.Result) -> None:
    assert one.verified and other.verified
    assert one.attempts == other.attempts and one.won == other.won
    assert other.require().problem.goals
    for name in ("times", "positions", "velocities", "accelerations"):
        assert np.array_equal(getattr(one.trajectory, name), getattr(other.trajectory, name)), name
    assert np.array_equal(one.path.knots, other.path.knots)


@dataclass(frozen=True)
class Elsewhere:
    """A method that does something else in any process but the one of the test."""

    deed: Callable[[], None]
    home: int = HERE
    name = "elsewhere"

    def objection(self, problem: to.Problem) -> str:
        return Knots().objection(problem)

    def program(
        self, problem: to.Problem, seed: np.ndarray, waypoint_knots: Sequence[int] = ()
    ) -> "ElsewhereProgram":
        return ElsewhereProgram(Knots().program(problem, seed, waypoint_knots), self.deed, self.home)


@dataclass(frozen=True)
class ElsewhereProgram:
    inner: Program
    deed: Callable[[], None]
    home: int

    @property
    def scale(self) -> np.ndarray:
        return self.inner.scale

    @property
    def counts(self) -> Counts:
        return self.inner.counts

    def solve(self, seed: np.ndarray, *, progress: Callable[[Iteration], None] | None = None) -> SolveResult:
        if os.getpid() != self.home:
            self.deed()
        return self.inner.solve(seed, progress=progress)

    def decode(self, solved: SolveResult) -> Sequence[Decoded]:
        return self.inner.decode(solved)


def die() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def fail() -> None:
    raise ZeroDivisionError("of the user's own code")


@pytest.mark.usefixtures("unproven")
def test_a_worker_that_dies_is_told(arm: to.Robot) -> None:
    result = to.plan(wall(arm), method=Elsewhere(die), budget=to.Budget(attempts=6, workers=2))
    assert result.status is Status.STUCK
    died = [item for item in result.attempts if item.status is Status.WORKER_DIED]
    assert len(died) == 5 and all("-9" in item.message for item in died)
    assert result.attempts[0].kind is SeedKind.STRAIGHT and result.attempts[0].status is Status.STUCK


@pytest.mark.usefixtures("unproven")
def test_an_error_in_a_worker_is_raised(arm: to.Robot) -> None:
    with pytest.raises(ZeroDivisionError, match="of the user's own code"):
        to.plan(walled_in(arm), method=Elsewhere(fail), budget=to.Budget(workers=2))


def test_workers_are_cancelled(arm: to.Robot) -> None:
    cancel = Event()
    result = to.plan(
        wall(arm),
        budget=to.Budget(attempts=40, improve=True, workers=2),
        cancel=cancel,
        on_incumbent=lambda best: cancel.set(),
    )
    assert result.stopped is Stop.CANCEL and result.verified
