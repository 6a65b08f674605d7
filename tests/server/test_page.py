"""docs/server.md, block by block, and what it says of statuses, operations and limits."""

import re
from pathlib import Path
from typing import Any, cast

import pytest

import trajopt as to
from tests.pages import DOCS, Page
from tests.server.serving import serving
from trajopt.server import Limits, Why
from trajopt.server.http.answers import STATUS
from trajopt.server.operations import OPERATIONS

TEXT = (DOCS / "server.md").read_text()


def test_every_block(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    try:
        to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    page = Page("server.md", tmp_path)
    with serving("panda", limits=Limits(workers=1)) as server:
        page.names["url"] = server.url
        page.run("A client in Python")
        told = capsys.readouterr().out
        assert "True SOLVED" in told and "'stage': 'optimise'" in told
        assert "400 malformed" in told and "did you mean 'panda_hand_tcp'" in told
        page.run("Operations")
        told = capsys.readouterr().out
        assert "True\n" in told and told.splitlines()[-1] == "True []"
        page.run("Point clouds")
        assert int(capsys.readouterr().out.split()[0]) > 0
        cast(Any, page.names["client"]).close()


def test_every_operation_and_refusal_is_on_the_page() -> None:
    for operation in OPERATIONS.keys() - {"read"}:
        assert f"| `{operation}` |" in TEXT
    for why in Why:
        assert re.search(rf"^\| [^|]*{STATUS[why]}[^|]* \| [^|]*`{why.value}`", TEXT, re.MULTILINE), why


def test_the_limits_are_those_on_the_page() -> None:
    limits = Limits()
    assert (limits.body, limits.seconds, limits.memory) == (16 * 2**20, 60.0, 1024 * 2**20)
    assert (limits.triangles, limits.points, limits.cloud) == (50_000, 20_000, 400_000)
