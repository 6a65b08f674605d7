"""A budget bounds planning exactly, is never exceeded by more than a step, and more is never worse."""

import time
from collections.abc import Callable
from threading import Event

import numpy as np
import pytest

import trajopt as to
from tests.planning.walls import wall, walled_in
from tests.robots_for_tests import odd_arm
from trajopt.planning.budget import WORK, BudgetTracker, Stop
from trajopt.planning.status import Status


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    return odd_arm(tmp_path_factory.mktemp("robot"))


class TickingClock:
    """Every look at it takes a second: what is counted is how often planning looks."""

    def __init__(self) -> None:
        self.looks = 0

    def __call__(self) -> float:
        self.looks += 1
        return float(self.looks)


@pytest.mark.usefixtures("unproven")
@pytest.mark.parametrize("seconds", [1.5, 5.5, 20.5, 60.5])
def test_the_clock_stops_planning_at_the_next_look(arm: to.Robot, seconds: float) -> None:
    clock = TickingClock()
    result = to.plan(walled_in(arm), budget=to.Budget(seconds=seconds, clock=clock))
    assert result.status is Status.OUT_OF_TIME
    assert result.stopped is Stop.CLOCK and result.stopped_by_clock and result.as_dict()["stopped_by_clock"]
    assert clock.looks == np.ceil(seconds) + 1, "one look starts the clock; after the last nothing goes on"
    if result.attempts:
        assert "so far: STUCK" in result.message


@pytest.mark.usefixtures("unproven")
def test_every_solver_step_checks_the_clock(arm: to.Robot) -> None:
    clock = TickingClock()
    steps: list[int] = []

    def progress(stage: str, step: object) -> None:
        del stage
        if step is not None:
            steps.append(clock.looks)

    to.plan(walled_in(arm), budget=to.Budget(seconds=900.5, clock=clock), progress=progress)
    assert len(steps) > 40 and len(set(steps)) == len(steps)


def test_work_is_an_exact_bound_and_repeats(arm: to.Robot) -> None:
    whole = to.plan(wall(arm))
    assert whole.verified and len(whole.attempts) > 1 and whole.stopped is None
    enough = to.plan(wall(arm), budget=to.Budget(work=whole.counts[WORK]))
    assert enough.verified and np.array_equal(enough.path.knots, whole.path.knots)
    short = [to.plan(wall(arm), budget=to.Budget(work=whole.counts[WORK] - 1)) for _ in range(2)]
    for result in short:
        assert result.status is Status.OUT_OF_WORK and result.stopped is Stop.WORK
        assert not result.stopped_by_clock
        assert result.attempts == whole.attempts[:-1]
    assert short[0].counts == short[1].counts


@pytest.mark.usefixtures("unproven")
def test_attempts_are_an_exact_bound(arm: to.Robot) -> None:
    alone = to.plan(wall(arm), budget=to.Budget(attempts=1))
    assert alone.status is Status.STUCK and len(alone.attempts) == 1
    assert to.plan(wall(arm), budget=to.Budget(attempts=30)).verified
    many = to.plan(walled_in(arm), budget=to.Budget(attempts=70))
    assert len(many.attempts) == 70, "a budget that allows more seeds gets more"


def test_cancelled_without_a_motion(arm: to.Robot) -> None:
    cancel = Event()

    def progress(stage: str, step: object) -> None:
        del step
        if stage == "optimise":
            cancel.set()

    result = to.plan(walled_in(arm), cancel=cancel, progress=progress)
    assert result.status is Status.CANCELLED and result.stopped is Stop.CANCEL
    cancel.set()
    assert to.plan(wall(arm), cancel=cancel).status is Status.CANCELLED


def _cancelling(cancel: Event) -> Callable[[to.Result], None]:
    return lambda result: cancel.set()


def _interrupting(result: to.Result) -> None:
    raise KeyboardInterrupt


def test_cancelled_with_a_motion_returns_it(arm: to.Robot) -> None:
    cancel, budget = Event(), to.Budget(attempts=40, improve=True)
    for result in (
        to.plan(wall(arm), budget=budget, cancel=cancel, on_incumbent=_cancelling(cancel)),
        to.plan(wall(arm), budget=budget, on_incumbent=_interrupting),
    ):
        assert result.verified and result.stopped is Stop.CANCEL
        assert result.require().certificate.verified


def test_interrupted_without_a_motion_raises(arm: to.Robot) -> None:
    def progress(stage: str, step: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        to.plan(wall(arm), progress=progress)


def test_more_budget_is_never_worse(arm: to.Robot) -> None:
    first = to.plan(wall(arm))
    costs = [first.cost]
    for attempts in (len(first.attempts), 10, 17):
        seen: list[float] = []
        result = to.plan(
            wall(arm),
            budget=to.Budget(attempts=attempts, improve=True),
            on_incumbent=lambda best, seen=seen: seen.append(best.cost),
        )
        assert result.verified and result.certificate is not None and result.certificate.verified
        assert seen == sorted(seen, reverse=True) and len(set(seen)) == len(seen)
        assert result.cost == seen[-1] == result.trajectory.duration
        assert result.won is not None and result.won in result.attempts
        costs.append(result.cost)
    assert costs == sorted(costs, reverse=True)
    assert costs[-1] < costs[0]


def test_never_worse_than_the_first_guess(arm: to.Robot) -> None:
    """Where the straight line is free, nothing is shorter in time, and the line itself is a candidate."""
    free = to.Problem(scene=to.Scene(arm), start=wall(arm).start, goal=wall(arm).goal)
    smooth = to.plan(free, budget=to.Budget(attempts=1))
    best = to.plan(free, budget=to.Budget(attempts=1, improve=True))
    assert best.cost <= smooth.cost
    assert best.path.knots == pytest.approx(np.linspace(best.path.knots[0], best.path.knots[-1], free.knots))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"seconds": 0.0}, "seconds must be positive"),
        ({"seconds": float("nan")}, "seconds"),
        ({"work": 0}, "work must be a positive whole number"),
        ({"attempts": 1.5}, "attempts must be a positive whole number"),
        ({"workers": -1}, "workers"),
        ({"improve": True}, "seconds, work or attempts"),
    ],
)
def test_a_budget_without_a_bound_is_refused(given: dict[str, object], words: str) -> None:
    with pytest.raises(to.TrajoptError, match=words):
        to.Budget(**given)  # pyright: ignore[reportArgumentType]


@pytest.mark.usefixtures("unproven")
def test_a_frozen_clock_does_not_block_planning(arm: to.Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    wall_clock = TickingClock()
    monkeypatch.setattr("trajopt.planning.budget.monotonic", wall_clock)
    result = to.plan(walled_in(arm), budget=to.Budget(seconds=2.0, clock=lambda: 0.0))
    assert result.status is Status.OUT_OF_TIME and result.stopped_by_clock
    assert wall_clock.looks == 31, "the first look starts the clock, and it ends after 10 x 2 s + 10 s"


def test_the_wall_needs_no_backstop_and_work_has_none() -> None:
    assert to.Budget(seconds=2.0).wall_seconds == 2.0
    assert to.Budget(work=10).wall_seconds is None
    assert to.Budget(seconds=2.0, clock=time.process_time).wall_seconds == 30.0


def test_a_nested_stage_does_not_count_for_the_outer_one(monkeypatch: pytest.MonkeyPatch) -> None:
    looks = iter([0.0, 1.0, 4.0, 6.0, 10.0, 11.0])
    monkeypatch.setattr(time, "thread_time", lambda: next(looks))
    tracker = BudgetTracker(to.Budget())
    with tracker.stage("optimise"), tracker.stage("verify"):
        pass
    with tracker.stage("verify"):
        pass
    assert tracker.seconds == {"optimise": 3.0, "verify": 4.0}
