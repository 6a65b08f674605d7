"""The page: complete in itself, and readable in a real browser."""

from base64 import b64encode
from pathlib import Path

import pytest

from tests.lab.suite.comparison.runs_for_tests import ALL
from trajopt.lab.suite.pages import comparison_page as page
from trajopt.viewer.plots import comparison_figures

CHROMIUM = Path("/usr/bin/chromium")


def test_needs_nothing_beside_itself() -> None:
    text = page(ALL, comparison_figures(ALL))
    assert text.startswith("<!doctype html>")
    for outside in ("http:", "https:", "<script", "url(", 'src="/'):
        assert outside not in text
    assert text.count('src="data:image/png;base64,') == 3
    assert "stuck &lt;here&gt;" in text


def test_pictures_of_the_motions_are_in_the_page_itself() -> None:
    first = ALL[0]
    drawn = {(first.problem, first.solver): b"a picture"}
    text = page(ALL, {}, drawn, remark="One <picture>.")
    encoded = b64encode(b"a picture").decode()
    assert text.count("src=") == 2, "beside the problem's name, and with the method's"
    assert text.count(f'src="data:image/jpeg;base64,{encoded}"') == 2
    assert "One &lt;picture&gt;." in text and f"<figcaption>{first.solver}" in text
    assert "<img" not in page(ALL, {})


@pytest.mark.parametrize("width", [420, 1250])
def test_fits_the_window(width: int, tmp_path: Path) -> None:
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if not CHROMIUM.is_file():
        pytest.skip(f"no browser at {CHROMIUM}")
    path = tmp_path / "compare.html"
    path.write_text(page(ALL, comparison_figures(ALL)), encoding="utf-8")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        opened = browser.new_page(viewport={"width": width, "height": 800})
        opened.set_default_timeout(60_000.0)
        opened.goto(path.as_uri())
        assert opened.evaluate("document.documentElement.scrollWidth") <= width
        assert opened.evaluate("[...document.images].every(image => image.naturalWidth > 500)")
        assert not opened.get_by_text("clearance by 0.04").is_visible()
        opened.get_by_text("box/1").last.click()
        assert opened.get_by_text("clearance by 0.04").is_visible()
        browser.close()
