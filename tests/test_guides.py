"""The Python blocks of the guides run as printed, each page in one namespace."""

import re
from pathlib import Path

import pytest

import trajopt as to

DOCS = Path(__file__).parents[1] / "docs"
BLOCK = re.compile(r"```python\n(.*?)```", re.DOTALL)
GUIDES = (
    "goals-and-scenes",
    "waypoints",
    "lines-and-curves",
    "pick-and-place",
    "machine-tending",
    "tasks",
    "dynamic-obstacles",
    "mobile-and-dual-arms",
    "when-planning-fails",
    "how-it-works",
)


def run_page(name: str) -> dict[str, object]:
    """Run all blocks of a page in order; return the names that they define."""
    try:
        to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    names: dict[str, object] = {"__name__": "page"}
    exec(compile("\n".join(BLOCK.findall((DOCS / f"{name}.md").read_text())), f"{name}.md", "exec"), names)
    return names


@pytest.mark.parametrize("name", GUIDES)
def test_its_blocks_run(name: str) -> None:
    run_page(name)
