"""What the README promises stands in a table, each promise beside the test that would see it broken."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "decisions" / "promises.md"
STRONG = re.compile(
    r"\b(proven|proves?|proofs?|never|always|all|every|everybody|anybody\w*|any|exact|exactly|independent|"
    r"same|whole|must|only|optimal|guarantee\w*)\b",
    re.IGNORECASE,
)
"""Words that promise something."""
CODE = re.compile(r"```.*?```|^    .*?$", re.DOTALL | re.MULTILINE)
ROW = re.compile(r"^\| (.+?) \| (.+?) \|$", re.MULTILINE)
TEST = re.compile(r"`(tests/[\w/]+\.py)::(\w+)`")
PLAIN = re.compile(r"^- (.+)$", re.MULTILINE)


def spoken(text: str) -> str:
    """Text without code, on one line."""
    return " ".join(CODE.sub("", text).split())


def readme() -> str:
    return spoken((ROOT / "README.md").read_text())


def promises() -> dict[str, str]:
    """Promise -> what tests it."""
    rows = ROW.findall(PAGE.read_text())
    return {spoken(promise): tests for promise, tests in rows if not promise.startswith(("-", "README"))}


def plain() -> list[str]:
    """Phrases of the README with one of the words that promise nothing."""
    return [spoken(phrase) for phrase in PLAIN.findall(PAGE.read_text())]


def unlisted(text: str, phrases: list[str]) -> list[str]:
    """Return where a text has one of the words outside the phrases."""
    covered = [
        (place.start(), place.end()) for phrase in phrases for place in re.finditer(re.escape(phrase), text)
    ]
    return [
        text[max(0, word.start() - 50) : word.end() + 40]
        for word in STRONG.finditer(text)
        if not any(first <= word.start() and word.end() <= last for first, last in covered)
    ]


def test_every_strong_word_of_the_readme_is_in_the_table() -> None:
    assert unlisted(readme(), [*promises(), *plain()]) == []


def test_the_table_says_what_the_readme_says() -> None:
    assert len(promises()) >= 20
    text = readme()
    assert [phrase for phrase in (*promises(), *plain()) if phrase not in text] == []


@pytest.mark.parametrize("promise", promises())
def test_its_tests_exist(promise: str) -> None:
    named = TEST.findall(promises()[promise])
    assert named, f"{promise!r} names no test"
    for file, name in named:
        found = re.search(rf"^def {name}\(", (ROOT / file).read_text(), re.MULTILINE)
        assert found, f"{file} has no {name}"


def test_a_promise_that_is_not_listed_is_seen() -> None:
    text = "It is fast. It never fails, and every row is held."
    assert len(unlisted(text, [])) == 2
    assert unlisted(text, ["It never fails"]) == [
        text[max(0, text.index("every") - 50) : 45 + text.index("every")]
    ]
