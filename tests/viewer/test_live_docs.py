"""docs/live-view.md, block by block."""

from pathlib import Path

import pytest

from tests.pages import DOCS, Page

from .test_viewer import free_port


def test_the_page_runs(tmp_path: Path) -> None:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    page = Page("live-view.md", tmp_path)
    page.sections["Beginning"] = (DOCS / "live-view.md").read_text().partition("\n## ")[0]
    page.names.update(port=free_port(), seconds=0.1)
    page.run("Beginning")
    page.names["page"].close()  # pyright: ignore
    page.run("A robot elsewhere")
