"""The code of the README runs as it is printed, but for what opens a window or writes a film."""

import re
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.timing import Retimed

README = Path(__file__).parents[1] / "README.md"
BLOCK = re.compile(r"```python\n(.*?)```", re.DOTALL)
WINDOWS = re.compile(r"^(to\.)?(render|view)\(.*$", re.MULTILINE)


def printed(blocks: list[str]) -> dict[str, object]:
    """Run blocks of the README one after the other; return their names."""
    names: dict[str, object] = {}
    exec(compile(WINDOWS.sub("", "\n".join(blocks)), "README.md", "exec"), names)
    return names


@pytest.fixture
def blocks() -> list[str]:
    try:
        to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    found = BLOCK.findall(README.read_text())
    assert len(found) >= 3
    return found


def test_its_code_runs(blocks: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    printed(blocks)
    said = capsys.readouterr().out
    assert "SOLVED" in said and "1.0 None" in said and "the fingers held the object" in said


def test_its_steps_are_what_plan_once_does(blocks: list[str]) -> None:
    assert "to.judge(" in blocks[1]
    names = printed(blocks[:2])
    problem, seed, motion, certificate = (names[x] for x in ("problem", "seed", "motion", "certificate"))
    assert isinstance(problem, to.Problem) and isinstance(seed, np.ndarray) and isinstance(motion, Retimed)
    once = to.plan_once(problem, seed).require()
    assert np.array_equal(once.trajectory.times, motion.trajectory.times)
    moments = np.linspace(0.0, once.trajectory.duration, 200)
    assert np.array_equal(once.trajectory(moments), motion.trajectory(moments))
    assert str(once.certificate) == str(certificate)
