"""One thread does what a page is asked for: in order, the last of a name only, and whatever fails."""

import threading
from collections.abc import Iterator

import pytest

import trajopt as to
from trajopt.values.errors import ProblemError
from trajopt.viewer.live.background import Planning, PlanningOutcome
from trajopt.viewer.live.panels import Desk
from trajopt.viewer.readout import planned_html

PATIENCE = 60.0


@pytest.fixture
def refused() -> list[str]:
    return []


@pytest.fixture
def desk(refused: list[str]) -> Iterator[Desk]:
    opened = Desk(refused.append)
    yield opened
    opened.close()


def test_of_one_name_only_the_last_is_done(desk: Desk) -> None:
    done, go = list[str](), threading.Event()
    desk.do("wait", lambda: bool(go.wait(PATIENCE)) and None)
    for count in range(100):
        desk.do("drag", lambda count=count: done.append(f"drag {count}"))
        desk.do("other", lambda count=count: done.append(f"other {count}"))
    go.set()
    assert desk.settle(PATIENCE)
    assert done[-2:] == ["drag 99", "other 99"] and len(done) <= 4


def test_a_refused_request_is_reported_and_the_desk_continues(desk: Desk, refused: list[str]) -> None:
    def refuse() -> None:
        raise ProblemError("no such box")

    def fail() -> None:
        raise ValueError("odd")

    done = list[int]()
    for name, work in (("a", refuse), ("b", fail), ("c", lambda: done.append(1))):
        desk.do(name, work)
    assert desk.settle(PATIENCE)
    assert refused == ["no such box", "a fault of this page (ValueError: odd)"] and done == [1]


def planned(asked: to.Problem | to.Result) -> tuple[PlanningOutcome, list[str]]:
    told, over = list[str](), threading.Event()

    def hear(planning: Planning) -> None:
        told.append(planning.words)
        if not planning.busy:
            over.set()

    planning = Planning(asked, hear)
    assert over.wait(PATIENCE)
    planning.close()
    assert planning.planned is not None
    return planning.planned, told


def test_planning_reports_progress_and_outcome() -> None:
    found, told = planned(to.named_problem("planar_fold"))
    assert found.result is not None and found.result.verified
    assert any("optimising" in words for words in told)
    words = planned_html(found)
    assert f"A motion of {found.result.cost:.2f} s" in words and "proven" in words


def test_a_failure_names_obstacle_and_remedies() -> None:
    arm = to.load("planar2")
    goal = to.joint_positions({"joint1": 1.2, "joint2": 0.0})
    scene = to.Scene(arm).add("wall", to.Box(2.0, 0.05, 2.0), to.placement((0.0, 0.5, 0.0)))
    problem = to.Problem(scene=scene, start={"joint1": 0.0, "joint2": 0.0}, goal=goal)
    found, _ = planned(problem)
    assert found.result is not None and not found.result.verified
    words = planned_html(found)
    assert "No motion was found" in words and "wall" in words
    assert "Cannot" not in words and "GOAL_IN" not in words


def test_an_invalid_problem_is_reported() -> None:
    words = planned_html(PlanningOutcome(None, None, "the <start> is odd"))
    assert "This cannot be planned" in words and "&lt;start&gt;" in words


def test_planning_is_cancelled() -> None:
    over = threading.Event()
    planning = Planning(to.named_problem("planar_fold"), lambda each: None if each.busy else over.set())
    planning.cancel()
    assert over.wait(PATIENCE)
    planning.close()
    assert planning.planned is not None and planning.planned.result is not None
    assert not planning.alive and planning.planned.result.stopped is not None
    assert "cancelled" in planned_html(planning.planned) or planning.planned.result.verified
