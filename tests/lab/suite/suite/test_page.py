"""The page: complete in itself, and readable in a real browser."""

from base64 import b64encode
from collections.abc import Iterator
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from PIL import Image

from tests.lab.suite.suite.outcomes import ALL, GOOD, REFUSED
from trajopt.lab.suite.pages import suite_page as page_of
from trajopt.simulation.rendering import HEIGHT, WIDTH

if TYPE_CHECKING:
    from playwright.sync_api import Page

CHROMIUM = Path("/usr/bin/chromium")


def test_needs_nothing_beside_itself() -> None:
    text = page_of(ALL)
    assert text.startswith("<!doctype html>")
    for outside in ("http:", "https:", "src=", "<script", "url("):
        assert outside not in text
    assert "tip &lt;of&gt; the arm" in text and "misses by 1 &lt; 2" in text


def test_a_refused_problem_shows_no_motion() -> None:
    tried = replace(REFUSED, duration=1.5)
    assert "motion of" not in page_of([tried]) and "motion of" in page_of([GOOD])


def test_pictures_are_in_the_page_itself() -> None:
    first = ALL[0]
    text = page_of(ALL, {(first.problem, first.draw): b"a picture"}, remark="One <picture>.")
    assert text.count("src=") == text.count('src="data:image/jpeg;base64,') == 1
    assert b64encode(b"a picture").decode() in text and "One &lt;picture&gt;." in text


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator["Page"]:
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if not CHROMIUM.is_file():
        pytest.skip(f"no browser at {CHROMIUM}")
    path = tmp_path_factory.mktemp("page") / "suite.html"
    picture = BytesIO()
    Image.new("RGB", (WIDTH, HEIGHT), "blue").save(picture, "JPEG")
    drawn = {(outcome.problem, outcome.draw): picture.getvalue() for outcome in ALL}
    path.write_text(page_of(ALL, drawn), encoding="utf-8")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        opened = browser.new_page(viewport={"width": 1100, "height": 800})
        opened.set_default_timeout(60_000.0)
        opened.goto(path.as_uri())
        yield opened
        browser.close()


def test_failures_stand_open_and_the_rest_opens(page: "Page") -> None:
    assert page.get_by_text("path: position").is_visible()
    assert page.locator("details[open]").count() == 2
    assert not page.get_by_text("goal: axis").is_visible()
    page.get_by_text("past a post").click()
    assert page.get_by_text("goal: axis").is_visible()
    assert page.get_by_text("1.250").is_visible()


def test_page_shows_the_outcome_of_each_problem(page: "Page") -> None:
    assert page.get_by_text("no inverse kinematics, expected solved").is_visible()
    assert page.get_by_text("motion of 1.50 s, 12.3 mm clear").first.is_visible()


@pytest.mark.parametrize("width", [420, 1100, 1600])
def test_fits_the_window(page: "Page", width: int) -> None:
    page.set_viewport_size({"width": width, "height": 800})
    assert page.evaluate("document.documentElement.scrollWidth") <= width
