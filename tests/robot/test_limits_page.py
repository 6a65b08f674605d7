"""docs/limits.md, block by block: what it says of limits is so."""

import re
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.conftest import PLANAR_ARM, PLANAR_ARM_SRDF
from tests.pages import Page

PRINTED = re.compile(r"(as stated|0\.1 s|0\.25 s) +([\d.]+) s, jerk at most (\d+) rad")


@pytest.fixture
def page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Page:
    (tmp_path / "my_arm.urdf").write_text(PLANAR_ARM)
    (tmp_path / "my_arm.srdf").write_text(PLANAR_ARM_SRDF)
    monkeypatch.chdir(tmp_path)
    return Page("limits.md", tmp_path)


def test_the_claims_of_the_page_hold(page: Page, capsys: pytest.CaptureFixture[str]) -> None:
    page.run("Sources of limits")
    said = capsys.readouterr().out
    assert "elbow acceleration 229.2 deg/s^2 (no limit stated)" in said
    arm, problem = page.names["arm"], None
    assert isinstance(arm, to.Robot)
    place = arm.index(["shoulder", "elbow"])
    assert arm.limits.velocity[place].tolist() == [2.0, 1.5]
    assert arm.limits.acceleration[place].tolist() == [3.0, 5.0]
    assert arm.limits.jerk[place].tolist() == [60.0, np.inf]

    page.run("Scaling")
    problem, result = page.names["problem"], page.names["result"]
    assert isinstance(problem, to.Problem) and isinstance(result, to.Result)
    assert problem.limits.velocity.tolist() == [1.0, 0.75]
    assert problem.limits.acceleration.tolist() == [0.75, 1.25]
    assert problem.limits.jerk.tolist() == [60.0, np.inf]
    motion = result.require().trajectory
    times = np.linspace(0.0, motion.duration, 2000)
    for order, most in ((1, problem.limits.velocity), (2, problem.limits.acceleration)):
        assert (np.abs(motion(times, order)) <= most * (1.0 + 1e-6)).all()
    careful = page.names["careful"]
    assert isinstance(careful, to.Robot)
    assert careful.limits.effort[place] == pytest.approx(0.7 * arm.limits.effort[place])

    page.run("Tool speed")
    assert re.search(r"^ok +path: tool speed +hand +(99|100)\b", capsys.readouterr().out, re.MULTILINE)


def test_a_longer_rise_is_gentler_and_takes_longer(page: Page, capsys: pytest.CaptureFixture[str]) -> None:
    page.run("Sources of limits", "Scaling", "Tool speed", "Gentle motion")
    said = capsys.readouterr().out
    assert "jerk limits of elbow" in said and "reached in 0.1 s" in said
    rows = PRINTED.findall(said)
    assert [name for name, _, _ in rows] == ["as stated", "0.1 s", "0.25 s"]
    durations, jerks = ([float(row[column]) for row in rows] for column in (1, 2))
    assert durations == sorted(durations) and durations[2] > durations[0]
    assert jerks[2] < jerks[1] < jerks[0]
    # 5 rad/s^2 in 0.25 s.
    assert jerks[2] <= 20.0


def test_every_section_with_blocks_is_run(page: Page) -> None:
    assert page.with_blocks == ["Sources of limits", "Scaling", "Tool speed", "Gentle motion"]
