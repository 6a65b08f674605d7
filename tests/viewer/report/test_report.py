"""What a report says of plans, failures and problems; and that what others wrote stays text."""

import json
import re
from dataclasses import replace
from html import unescape
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.files.bundle import Bundle, read_bundle
from trajopt.planning.result import Plan
from trajopt.problem.problem import named_problem
from trajopt.robot.loading.pinocchio_model import link_placement
from trajopt.values.errors import FileFormatError, ProblemError
from trajopt.values.trajectory import Path as PlannedPath
from trajopt.viewer.report import write_report
from trajopt.viewer.report.measured import SAMPLES, amount, measured, subject_of
from trajopt.viewer.report.page import scenery
from trajopt.viewer.report.sections import change_of_duration, plot, ticks

from .conftest import HOSTILE


def text_of(what: to.Result | Plan | to.Problem | Bundle, folder: Path) -> str:
    """A report without pictures, which take longest."""
    path = write_report(what, folder / "report.html", moving=False, pictures=False)
    return path.read_text(encoding="utf-8")


def titles(page: str) -> list[str]:
    return [unescape(title) for title in re.findall(r"<h2>(.*?)</h2>", page)]


def test_a_plan(plan: to.Result, tmp_path: Path) -> None:
    page = text_of(plan, tmp_path)
    assert titles(page) == [
        *("What was proven", "Where limits bind", "What the constraints cost"),
        *("Over time", "What was tried", "What was asked"),
    ]
    assert plan.certificate is not None and plan.trajectory is not None
    checks = sum(check.required for check in plan.certificate.checks)
    assert f"All {checks} checks of the judge hold" in page
    assert f"{plan.trajectory.duration:.3f} s" in page
    for what in (
        "Joint positions",
        "Joint velocities",
        "Joint accelerations",
        "Smallest clearance",
        "Speed of",
    ):
        assert what in page
    assert "the straight line to the nearest goal configuration" in page and "optimising" in page
    assert "ms shorter" in page


def test_a_proof_is_shown_with_its_size_and_statement(plan: to.Result, tmp_path: Path) -> None:
    plan.save(tmp_path / "kept.trajopt", proof=True)
    bundle = read_bundle(tmp_path / "kept.trajopt")
    assert bundle.proof is not None
    page = unescape(text_of(bundle, tmp_path))
    assert "Proof file" in titles(page)
    assert '<b class="good">PROVEN</b>' in page and str(bundle.proof.size) in page
    assert "the motion has the stated start" in page and "ends at rest" in page


def test_a_bundle_reports_the_same_as_its_result(plan: to.Result, kept: Bundle, tmp_path: Path) -> None:
    def without_date(page: str) -> str:
        return re.sub(r"<footer>.*?</footer>", "", page)

    (tmp_path / "one").mkdir()
    assert without_date(text_of(kept, tmp_path / "one")) == without_date(text_of(plan, tmp_path))


def test_the_verdict_in_a_bundle_is_not_trusted(kept: Bundle, tmp_path: Path) -> None:
    assert kept.trajectory is not None
    faster = replace(kept.trajectory, times=0.2 * kept.trajectory.times, velocities=None, accelerations=None)
    page = text_of(replace(kept, trajectory=faster), tmp_path)
    assert "Not proven" in page and "What the judge found" in page and "✓ Proven" not in page


def test_a_failure_names_the_obstacle_and_the_nearest_free_configuration(
    failure: to.Result, tmp_path: Path
) -> None:
    failure.save(tmp_path / "failure.trajopt")
    for what in (failure, read_bundle(tmp_path / "failure.trajopt")):
        page = text_of(what, tmp_path)
        assert titles(page)[0] == "What stands in the way"
        assert "No plan: goal in collision." in page
        assert "The nearest configuration that is free" in page and "moved by" in page
    ghosts = [each.name for each in scenery(subject_of(failure)).ghosts]
    assert ghosts == ["blocked", "free"]


def test_a_goal_out_of_reach_has_the_nearest_configuration_as_moved_from_the_start(tmp_path: Path) -> None:
    goal = to.placement((3.0, 0.0, 0.0))
    result = to.plan(to.Problem(scene=to.Scene(to.load("planar2")), start=[0.5, 0.5], goal=goal))
    nearest, page = result.explain(plan_again=False).nearest_free, text_of(result, tmp_path)
    assert nearest is not None and np.abs(nearest.moved).max() > 0.1
    assert all(f"{each:+.2f} deg" in page for each in np.degrees(nearest.moved))


def test_a_problem_alone(failure: to.Result, tmp_path: Path) -> None:
    failure.problem.save(tmp_path / "problem.trajopt")
    for what in (failure.problem, read_bundle(tmp_path / "problem.trajopt")):
        page = text_of(what, tmp_path)
        assert titles(page) == ["What was asked"]
        assert "It is not planned yet." in page
    assert [each.name for each in scenery(subject_of(failure.problem)).ghosts] == ["goal"]


def test_a_plan_without_planning_data(plan: to.Result, tmp_path: Path) -> None:
    page = text_of(plan.require(), tmp_path)
    assert "✓ Proven" in page and "What was tried" not in titles(page)


@pytest.mark.parametrize("name", ["goal_beyond_limits", "start_in_collision", "motors_too_weak"])
def test_failures_of_every_kind_are_reported(name: str, tmp_path: Path) -> None:
    try:
        result = to.plan(named_problem(name))
    except to.MissingExtra as error:
        pytest.skip(str(error))
    page = text_of(result, tmp_path)
    assert "No plan" in page and titles(page)[0] == "What stands in the way"


def test_a_path_that_came_near_is_walked(failure: to.Result) -> None:
    """Of what has no timing, the clock says so."""
    knots = np.linspace([0.0, 0.4], [0.6, 0.4], 24)
    stuck = replace(failure, path=PlannedPath(failure.problem.reduced.joint_names, knots))
    shown = scenery(subject_of(stuck))
    assert shown.motion is not None and not shown.timed and "no timing" in shown.words


def test_nothing_that_others_wrote_is_more_than_text(plan: to.Result, kept: Bundle, tmp_path: Path) -> None:
    """Names of problems and objects, and every text of a bundle's answer and explanation."""
    hostile = {"kind": HOSTILE, "status": HOSTILE, "message": HOSTILE, "goal_name": HOSTILE}
    answer = {
        **kept.answer,
        "status": HOSTILE,
        "message": HOSTILE,
        "method": {"name": HOSTILE, "because": HOSTILE},
        "tries": [{"number": 1, "iterations": 2, **hostile}],
        "cpu_seconds": {HOSTILE: 1.0, "total": 1.0},
    }
    block = {"kind": "CONTACT", "words": HOSTILE, "subjects": [HOSTILE, HOSTILE]}
    explanation = {
        "blocks": [block] * 20,
        "conflict": [HOSTILE],
        "details": [HOSTILE],
        "remedies": [{"words": HOSTILE}],
        "grounds": HOSTILE,
        "certainty": HOSTILE,
        "nearest_free": {"positions": [0.0, 0.0], "moved": [0.0, 0.0], "clearance": 0.1},
    }
    versions = {HOSTILE: HOSTILE}
    told = replace(
        kept, trajectory=None, answer=answer, explanation=explanation, versions=versions, made=HOSTILE
    )
    for what in (kept, plan, told):
        page = text_of(what, tmp_path)
        assert "window.hacked" in page and page.count("<script") == 1
        assert not re.search(r"<[^>]*onerror", page)


WRONG: tuple[tuple[str, dict[str, object], str], ...] = (
    ("answer", {"tries": 5}, "answer.tries: must be a list"),
    ("answer", {"tries": [{"kind": 5}]}, r"answer.tries\[0\].kind: must be text"),
    ("answer", {"cpu_seconds": {"total": "x"}}, "answer.cpu_seconds.total: must be a number"),
    ("answer", {"status": [1]}, "answer.status: must be text"),
    ("explanation", {"configuration": [1.0]}, "explanation.configuration: .*shape"),
    ("explanation", {"nearest_free": {"positions": [1.0, "x"]}}, "must be a number"),
    ("explanation", {"blocks": [{"words": 3}]}, r"explanation.blocks\[0\].words: must be text"),
)
"""What a bundle's plain data must not be, and what is said of it."""


@pytest.mark.parametrize(("part", "value", "said"), WRONG)
def test_an_invalid_field_is_refused_with_its_place(
    kept: Bundle, tmp_path: Path, part: str, value: dict[str, object], said: str
) -> None:
    path = tmp_path / "report.html"
    with pytest.raises(FileFormatError, match=said):
        write_report(replace(kept, trajectory=None, **{part: value}), path, moving=False, pictures=False)
    assert not path.exists()


def test_arguments_of_another_kind_are_refused(plan: to.Result, tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match="what"):
        write_report("plan.trajopt", tmp_path / "report.html")  # pyright: ignore[reportArgumentType]
    with pytest.raises(ProblemError, match="moving"):
        write_report(plan, tmp_path / "report.html", moving=1)  # pyright: ignore[reportArgumentType]


def test_its_measurements_equal_the_judges(plan: to.Result) -> None:
    """Peaks, clearance and what binds, against the judge's own numbers."""
    assert plan.trajectory is not None and plan.certificate is not None
    seen = measured(plan.problem, plan.trajectory)
    judged = {check.name: check for check in plan.certificate.checks}
    velocity = judged["velocity"]
    column = plan.problem.reduced.joint_names.index(velocity.subject)
    assert velocity.value is not None and velocity.bound is not None
    most = seen.peaks[column].most[0]
    assert most is not None
    assert most[1] == pytest.approx(abs(velocity.value) / velocity.bound, abs=0.01)
    clearance = next(chart for chart in seen.charts if chart.title == "Smallest clearance")
    smallest = 1e-3 * min(np.nanmin(line.values) for line in clearance.lines)
    nearest = plan.certificate.pairs[0]
    assert smallest == pytest.approx(nearest.measured, abs=1e-3)
    assert seen.bindings, "a motion that is as fast as it can be is at some limit"
    for item in seen.bindings:
        assert all(0.0 <= begin < end <= plan.trajectory.duration for begin, end in item.spans)


def test_the_tool_is_as_fast_as_it_moves(planar: to.Scene) -> None:
    """Against the length of the arc that the tip draws: one joint turns, the other stands."""
    times = np.array([0.0, 1.0])
    problem = to.Problem(scene=planar, start=[0.0, 0.0], goal={"joint1": 1.0, "joint2": 0.0})
    turning = to.Trajectory(("joint1", "joint2"), times, np.array([[0.0, 0.0], [1.0, 0.0]]))
    speed = next(chart for chart in measured(problem, turning).charts if chart.unit == "m/s")
    values = speed.lines[0].values
    assert len(values) == SAMPLES
    np.testing.assert_allclose(values, values[0], rtol=1e-6)
    at = link_placement(planar.robot.model, speed.lines[0].name, np.zeros(2))
    reach = np.linalg.norm(at.translation[:2])
    assert values[0] == pytest.approx(float(reach), rel=1e-6)


def test_speeds_of_tools_that_are_limited_are_shown_beside_the_limit(planar: to.Scene) -> None:
    frame = planar.robot.links[-1]
    slow = to.tool_speed(frame, linear=0.2)
    result = to.plan(
        to.Problem(scene=planar, start=[0.0, 0.4], goal={"joint1": 1.0, "joint2": 0.4}, tool_speed=slow)
    )
    assert result.trajectory is not None
    seen = measured(result.problem, result.trajectory)
    chart = next(chart for chart in seen.charts if chart.unit == "m/s")
    assert chart.limits == ((0.2, "limit"),)
    assert any(item.name == f"{frame}: speed" for item in seen.bindings)
    assert "limit 0.2 m/s" in plot(chart)


@pytest.mark.parametrize(
    ("lower", "upper", "expected"),
    [(0.0, 1.0, [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]), (-106.0, 106.0, [-100, -50, 0, 50, 100])],
)
def test_ticks_are_round(lower: float, upper: float, expected: list[float]) -> None:
    assert ticks(lower, upper) == pytest.approx(expected)


def test_numbers_are_written_as_people_do() -> None:
    assert [amount(value) for value in (0.1691, 93.71, 257_204.0)] == ["0.169", "93.7", "257,000"]


def test_the_command(kept: Bundle, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from trajopt.cli import app_for

    out = tmp_path / "deep" / "report.html"
    words = ["report", str(kept.path), "--out", str(out), "--no-3d", "--no-pictures"]
    app_for(words)(words, standalone_mode=False)
    assert "MB" in capsys.readouterr().out and out.is_file()
    app_for(words)([*words, "--json"], standalone_mode=False)
    assert json.loads(capsys.readouterr().out)["bytes"] == out.stat().st_size


def test_a_motion_that_takes_more_time_is_longer() -> None:
    assert change_of_duration(-2.6e-3) == "2.6 ms longer"
    assert change_of_duration(0.154) == "150 ms shorter"
    assert change_of_duration(2.6e-3) == "2.6 ms shorter"
