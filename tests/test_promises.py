"""Each claim of the table of claims names tests that exist."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "decisions" / "promises.md"
ROW = re.compile(r"^\| (.+?) \| (`tests.+?) \|$", re.MULTILINE)
TEST = re.compile(r"`(tests/[\w/]+\.py)::(\w+)`")


def defines(file: str, name: str) -> bool:
    path = ROOT / file
    return path.exists() and re.search(rf"^def {name}\(", path.read_text(), re.MULTILINE) is not None


def test_the_tests_of_each_claim_exist() -> None:
    rows = ROW.findall(PAGE.read_text())
    assert len(rows) >= 20
    assert [claim for claim, tests in rows if not TEST.findall(tests)] == []
    named = [test for _, tests in rows for test in TEST.findall(tests)]
    assert [f"{file}::{name}" for file, name in named if not defines(file, name)] == []
