"""Each script of examples/ is a page, runs from any folder, and prints the outcome that it is about."""

import runpy
import sys
from pathlib import Path

import pytest

import trajopt as to

EXAMPLES = Path(__file__).parents[1] / "examples"
PAGE = 100
"""Lines of a page."""
PRINTED = {
    "dual_arm": ("goal: position  right_panda_hand_tcp", "verified: all"),
    "dynamic_obstacle": ("proven given that box is within 10 mm", "verified: all"),
    "first_plan": ("path: axis", "verified: all"),
    "line_and_arc": ("100.00% of 0.3917 m followed, proven",),
    "mobile_base": ("rolling", "verified: all"),
    "obstacles_and_margins": ("required 30 mm", "CLEARANCE_IMPOSSIBLE"),
    "own_constraint": ("path: bend of the elbow", "verified: all"),
    "pick_and_place": ("the judge verified every motion", "the cup is at (0.5, 0.25, 0.06) m"),
    "supervised_drive": ("world changed", "reached", "0 contacts at fault"),
    "waypoints": ("waypoint far right: position", "verified: all"),
}
"""Texts that the scripts print, by their names."""


def test_there_are_these_and_each_is_a_page() -> None:
    assert {path.stem for path in EXAMPLES.glob("*.py")} == set(PRINTED)
    lengths = {path.name: len(path.read_text().splitlines()) for path in EXAMPLES.rglob("*.py")}
    assert {name: lines for name, lines in lengths.items() if lines > PAGE} == {}


@pytest.mark.parametrize("name", PRINTED)
def test_runs(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = EXAMPLES / f"{name}.py"
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [str(path)])
    try:
        runpy.run_path(str(path), run_name="__main__")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    told = capsys.readouterr().out
    assert [text for text in PRINTED[name] if text not in told] == [], told


@pytest.mark.slow
def test_the_first_one_draws(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, picture = EXAMPLES / "first_plan.py", tmp_path / "cup.gif"
    monkeypatch.setattr(sys, "argv", [str(path), str(picture)])
    try:
        runpy.run_path(str(path), run_name="__main__")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    assert picture.read_bytes().startswith(b"GIF")
