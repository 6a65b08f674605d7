"""The code of the README runs as it is printed, but for what opens a window or writes a film."""

import re
from pathlib import Path

import pytest

import trajopt as to

README = Path(__file__).parents[1] / "README.md"
BLOCK = re.compile(r"```python\n(.*?)```", re.DOTALL)
SHOWN = re.compile(r"^(render|view)\(.*$", re.MULTILINE)


def test_its_code_runs(capsys: pytest.CaptureFixture[str]) -> None:
    try:
        to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    blocks = BLOCK.findall(README.read_text())
    assert len(blocks) >= 3
    names: dict[str, object] = {}
    exec(compile(SHOWN.sub("", "\n".join(blocks)), "README.md", "exec"), names)
    said = capsys.readouterr().out
    assert "SOLVED" in said and "1.0 None" in said and "the fingers held the object" in said
