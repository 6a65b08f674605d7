"""What comes after planning takes a plan, or a result that has one: no inner values are asked for."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import trajopt as to
from trajopt.simulation import CameraView, RenderingUnavailable, render, simulate
from trajopt.values.errors import FileFormatError, PlanningFailed, ProblemError

CAMERA = CameraView(np.array((0.5, 0.0, 0.0)), 3.0, 0.5, -0.6)


@pytest.fixture(scope="module")
def result() -> to.Result:
    scene = to.Scene(to.load("planar2"))
    goal = to.joint_positions({"joint1": 0.3, "joint2": 0.2})
    return to.plan(to.Problem(scene=scene, start={}, goal=goal))


@pytest.fixture(scope="module")
def failed() -> to.Result:
    scene = to.Scene(to.load("planar2"))
    return to.plan(to.Problem(scene=scene, start={}, goal=to.joint_positions({"joint1": 100.0})))


def test_functions_at_the_top_are_those_of_their_packages() -> None:
    code = (
        "import trajopt as to, trajopt.simulation.spec, trajopt.viewer.plots\n"
        "from trajopt.simulation import simulate, render\nfrom trajopt.viewer import view\n"
        "assert to.simulate is simulate and to.render is render and to.view is view"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_plan_and_its_result_are_simulated(result: to.Result) -> None:
    plan = result.require()
    rollouts = [to.simulate(result), to.simulate(plan), simulate(plan.problem.reduced, plan.trajectory)]
    for rollout in rollouts[1:]:
        np.testing.assert_array_equal(rollout.positions, rollouts[0].positions)


def test_a_plan_is_viewed(result: to.Result) -> None:
    pytest.importorskip("viser")
    for viewer in (to.view(result, port=8931), to.view(result.require(), port=8931)):
        np.testing.assert_array_equal(viewer.positions, result.require().trajectory(0.0))
        viewer.close()


def test_forms_of_render(result: to.Result, tmp_path: Path) -> None:
    plan, rollout = result.require(), to.simulate(result)
    size: dict[str, Any] = {"width": 64, "height": 48, "moments": [0.0]}
    try:
        files = [
            to.render(plan, tmp_path / "plan.png", **size),
            to.render(result, str(tmp_path / "result.png"), **size),
            render(plan.problem.reduced, plan.trajectory, tmp_path / "reduced.png", **size),
        ]
        simulated = [
            to.render(rollout, tmp_path / "rollout.png", **size),
            to.render(plan, rollout, tmp_path / "both.png", **size),
        ]
    except to.TrajoptError as error:
        pytest.skip(str(error))
    assert len({file.read_bytes() for file in files}) == 1
    assert len({file.read_bytes() for file in simulated}) == 1


@pytest.mark.parametrize(
    "call",
    [to.simulate, to.view, lambda result: to.render(result, "never.png")],
    ids=["simulate", "view", "render"],
)
def test_planning_failure_reports_its_status(failed: to.Result, call: Callable[[to.Result], object]) -> None:
    with pytest.raises(PlanningFailed, match="GOAL_OUT_OF_LIMITS"):
        call(failed)


def test_results_without_a_plan_are_refused(result: to.Result) -> None:
    reduced = result.problem.reduced
    for wrong in (3, "plan", [0.0] * 10_000):
        with pytest.raises(ProblemError, match="give a plan") as refused:
            to.simulate(wrong)  # type: ignore[call-overload]
        assert len(str(refused.value)) < 200
    for call in (
        lambda: to.simulate(reduced),  # type: ignore[call-overload]
        lambda: to.view(reduced),  # type: ignore[call-overload]
        lambda: to.render(reduced, "never.png"),
        lambda: to.render(result, result.require().trajectory),
        lambda: to.render(result, "one.png", "other.png"),
    ):
        with pytest.raises(ProblemError):
            call()


def test_the_start_of_a_problem_is_drawn_before_it_is_planned(result: to.Result, tmp_path: Path) -> None:
    size: dict[str, Any] = {"width": 160, "height": 120}
    problem, plan = result.problem, result.require()
    try:
        start = to.render(problem, tmp_path / "start.png", **size)
        shown_from: dict[str, Any] = {"moments": [0.0], "camera": CAMERA, **size}
        begin = to.render(plan, tmp_path / "begin.png", **shown_from)
        same = to.render(problem, tmp_path / "same.png", camera=CAMERA, **size)
    except RenderingUnavailable as error:
        pytest.skip(str(error))
    with Image.open(start) as drawn, Image.open(begin) as first, Image.open(same) as second:
        assert drawn.size == (160, 120)
        # The same robot at the same place; of a plan there is its path, too.
        apart = np.abs(np.asarray(first, dtype=float) - np.asarray(second, dtype=float)).max(axis=2) > 60
        assert apart.mean() < 0.05
    with pytest.raises(FileFormatError, match=r"no motion; its start is drawn as \.png"):
        to.render(problem, tmp_path / "start.gif", **size)


@pytest.mark.parametrize("call", [to.simulate, to.view, lambda what: to.render(what, "never.png")])
def test_errors_for_a_scene_or_problem_suggest_how_to_view_it(
    result: to.Result, call: Callable[[object], object]
) -> None:
    with pytest.raises(ProblemError, match=r"to look at a scene: trajopt\.viewer\.live_view"):
        call(result.problem.scene)
    if call in (to.simulate, to.view):
        with pytest.raises(ProblemError, match=r"draw its start: render\(problem"):
            call(result.problem)


def test_a_result_is_explained(result: to.Result) -> None:
    assert str(to.explain(result, plan_again=False)) == str(result.explain())
