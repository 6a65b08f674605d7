"""What trajopt says to typical mistakes is what the page says, and fit to be read."""

import pytest

from tests.mistakes import PAGE, SECTIONS, answers, page

LONGEST = 330


@pytest.fixture(scope="module")
def heard() -> dict[str, tuple[str, str, str]]:
    return {mistake.code: (mistake.error, kind, message) for _, mistake, kind, message in answers()}


def test_every_mistake_is_answered_by_its_error(heard: dict[str, tuple[str, str, str]]) -> None:
    assert sum(map(len, SECTIONS.values())) == len(heard) >= 60
    for code, (expected, kind, _) in heard.items():
        assert kind == expected, code


def test_messages_are_short_and_contain_no_addresses(heard: dict[str, tuple[str, str, str]]) -> None:
    for code, (_, _, message) in heard.items():
        assert 10 < len(message) <= LONGEST, f"{code}: {message}"
        assert "0x" not in message and "array(" not in message and "\n" not in message, f"{code}: {message}"


def test_the_page_is_up_to_date() -> None:
    assert PAGE.read_text() == page(), "python -m tests.mistakes writes it"
