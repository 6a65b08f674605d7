"""The code of the README runs as printed, except calls that open a window or write a film."""

import re
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.test_guides import BLOCK, run_page
from trajopt.timing import Retimed

README = Path(__file__).parents[1] / "README.md"
WINDOWS = re.compile(r"^(to\.)?(render|view)\(.*$", re.MULTILINE)


def test_its_code_runs(capsys: pytest.CaptureFixture[str]) -> None:
    blocks = BLOCK.findall(README.read_text())
    assert blocks
    try:
        exec(compile(WINDOWS.sub("", "\n".join(blocks)), "README.md", "exec"), {})
    except to.MissingExtra as error:
        pytest.skip(str(error))
    assert "SOLVED" in capsys.readouterr().out


def test_it_is_short() -> None:
    assert len(README.read_text().splitlines()) <= 220


def test_the_steps_of_the_guide_are_those_of_plan_once() -> None:
    names = run_page("how-it-works")
    problem, seed, motion, certificate = (names[x] for x in ("problem", "seed", "motion", "certificate"))
    assert isinstance(problem, to.Problem) and isinstance(seed, np.ndarray) and isinstance(motion, Retimed)
    once = to.plan_once(problem, seed).require()
    assert np.array_equal(once.trajectory.times, motion.trajectory.times)
    moments = np.linspace(0.0, once.trajectory.duration, 200)
    assert np.array_equal(once.trajectory(moments), motion.trajectory(moments))
    assert str(once.certificate) == str(certificate)
