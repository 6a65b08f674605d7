"""docs/from-compas-fab.md: what it says of services and error codes is so."""

import re
from pathlib import Path

from trajopt.files.messages import MoveItErrorCodes
from trajopt.ros.rosbridge.actions import ACTIONS, EDITS, SERVICES
from trajopt.server.move_group.outcome import CODES

PAGE = (Path(__file__).parents[3] / "docs" / "from-compas-fab.md").read_text()
ROWS = dict(re.findall(r"^\| ([A-Z_]+) \| (.*) \|$", PAGE, re.MULTILINE))


def test_every_status_has_the_code_given_on_the_page() -> None:
    told = {
        status: getattr(MoveItErrorCodes, code)
        for code, row in ROWS.items()
        for status in re.findall(r"`([A-Z_]+)`", row)
    }
    assert told == {status.name: code for status, code in CODES.items()}


def test_the_page_lists_every_service_topic_and_action() -> None:
    for name in (*SERVICES, *ACTIONS, *EDITS):
        assert f"`{name}`" in PAGE, name
