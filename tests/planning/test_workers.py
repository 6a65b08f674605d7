"""Several threads: the same answer as one."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from threading import Event, current_thread, main_thread
from threading import enumerate as enumerate_threads

import numpy as np
import pytest

import trajopt as to
from tests.planning.walls import wall, walled_in
from tests.robots_for_tests import odd_arm
from trajopt.geometry import WorkCounts
from trajopt.optimise.methods import Decoded, Knots, Program
from trajopt.optimise.solvers import Iteration, SolveResult
from trajopt.planning.budget import Stop
from trajopt.planning.status import Status


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    return odd_arm(tmp_path_factory.mktemp("robot"))


@pytest.mark.parametrize("inner_edge", [0.5, 0.55])
def test_the_answer_is_the_same_with_any_number_of_workers(arm: to.Robot, inner_edge: float) -> None:
    alone = to.plan(wall(arm, inner_edge), rng=np.random.default_rng(3))
    several = to.plan(wall(arm, inner_edge), rng=np.random.default_rng(3), budget=to.Budget(workers=3))
    _same(alone, several)
    assert len(alone.attempts) > 1, "from the second on they are made in threads"
    assert alone.counts["qp_solves"] == several.counts["qp_solves"]


def test_an_improved_answer_is_the_same_with_any_number_of_workers(arm: to.Robot) -> None:
    one, three = (
        to.plan(wall(arm), budget=to.Budget(attempts=17, improve=True, workers=workers)) for workers in (1, 3)
    )
    _same(one, three)
    assert len(one.attempts) == 17


def test_an_exhausted_answer_is_the_same_with_any_number_of_workers(arm: to.Robot) -> None:
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
    assert np.array_equal(one.require().path.knots, other.require().path.knots)


@dataclass(frozen=True)
class Broken:
    """A method with an error that shows from the second program on."""

    fails: Callable[[], None]
    name = "broken"

    def objection(self, problem: to.Problem) -> str:
        return Knots().objection(problem)

    def program(
        self, problem: to.Problem, seed: np.ndarray, waypoint_knots: Sequence[int] = ()
    ) -> "BrokenProgram":
        return BrokenProgram(Knots().program(problem, seed, waypoint_knots), self.fails)


@dataclass(frozen=True)
class BrokenProgram:
    inner: Program
    fails: Callable[[], None]

    @property
    def scale(self) -> np.ndarray:
        return self.inner.scale

    @property
    def counts(self) -> WorkCounts:
        return self.inner.counts

    def solve(self, seed: np.ndarray, *, progress: Callable[[Iteration], None] | None = None) -> SolveResult:
        if current_thread() is not main_thread():
            self.fails()
        return self.inner.solve(seed, progress=progress)

    def decode(self, solved: SolveResult) -> Sequence[Decoded]:
        return self.inner.decode(solved)


def fail() -> None:
    raise ZeroDivisionError("of the user's own code")


@pytest.mark.usefixtures("unproven")
def test_an_error_in_a_worker_is_raised(arm: to.Robot) -> None:
    with pytest.raises(ZeroDivisionError, match="of the user's own code"):
        to.plan(walled_in(arm), method=Broken(fail), budget=to.Budget(workers=2))


def test_workers_are_cancelled(arm: to.Robot) -> None:
    cancel = Event()
    result = to.plan(
        wall(arm),
        budget=to.Budget(attempts=40, improve=True, workers=2),
        cancel=cancel,
        on_incumbent=lambda best: cancel.set(),
    )
    assert result.stopped is Stop.CANCEL and result.verified


def test_no_worker_is_left_behind(arm: to.Robot) -> None:
    to.plan(wall(arm), rng=np.random.default_rng(3), budget=to.Budget(workers=3))
    assert not [thread for thread in enumerate_threads() if thread.name.startswith("trajopt")]


def test_methods_and_clocks_that_cannot_be_pickled_will_do(arm: to.Robot) -> None:
    alone = to.plan(wall(arm), rng=np.random.default_rng(3))
    budget = to.Budget(workers=2, seconds=100.0, clock=lambda: 0.0)
    _same(alone, to.plan(wall(arm), rng=np.random.default_rng(3), budget=budget))
