"""Outcomes as text and as data."""

import json
from dataclasses import replace

from tests.lab.suite.suite.outcomes import ALL, CLEAR, FAILED, FALSE, GOOD, REFUSED
from trajopt.lab.suite import RunOutcome
from trajopt.lab.suite.pages import suite_page as page
from trajopt.lab.suite.pages import summary, text_table


def test_as_expected() -> None:
    assert GOOD.good and REFUSED.good
    assert not FALSE.good, "a judge that finds a broken constraint makes a success a failure"
    assert not FAILED.good


def test_table_shows_every_constraint() -> None:
    lines = text_table(ALL)
    assert len(lines) == 1 + 3 + 2 + 1 + 1
    assert lines[1].split()[:4] == ["ok", "past", "a", "post"]
    assert "0.0123" in lines[1] and "0.500" in lines[1] and "clearance" in lines[1]
    assert lines[4].startswith("FAIL") and "random 3" in lines[4]
    assert "BROKEN path: position" in lines[5] and "0.750" in lines[5]
    assert lines[6].endswith("refused: NO_INVERSE_KINEMATICS")
    assert lines[7].startswith("FAIL") and lines[7].endswith("expected solved")


def test_summary() -> None:
    assert summary(ALL) == "2 of 4 as expected; planning took 2.0 s of CPU"


def test_as_data() -> None:
    for outcome in ALL:
        assert RunOutcome.from_dict(json.loads(json.dumps(outcome.as_dict(), allow_nan=False))) == outcome


def test_a_required_clearance_is_shown_next_to_the_kept_one() -> None:
    kept = replace(CLEAR, value=0.0345, bound=0.03)
    outcome = replace(GOOD, constraints=(kept, CLEAR))
    line = text_table([outcome])[1]
    assert "0.0345" in line and "0.03 " in line
    assert "34.5 mm clear (30 mm required), 12.3 mm clear<" in page([outcome])
