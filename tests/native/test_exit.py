"""A program that plans ends in silence, and as it should, however it does so."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import trajopt as to

BEGIN = """
import trajopt as to

if __name__ == "__main__":
    problem = to.named_problem("{problem}")
    assert to.plan(problem).verified
"""

ENDINGS = {
    "at once": "",
    "kept in a cache": """
    from functools import lru_cache
    from trajopt.geometry import Query
    kept = lru_cache(lambda: (Query(problem.reduced), to.plan(problem)))
    kept()
""",
    "after threads": """
    from concurrent.futures import ThreadPoolExecutor
    with ThreadPoolExecutor(2) as threads:
        assert all(result.verified for result in threads.map(to.plan, [problem] * 4))
""",
    "after processes": """
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context
    with ProcessPoolExecutor(1, get_context("spawn")) as processes:
        assert all(result.verified for result in processes.map(to.plan, [problem]))
""",
}

WHILE_PLANNING = """
    import threading

    begun = threading.Barrier(3)

    def for_ever():
        begun.wait()
        while True:
            to.plan(problem)

    for _ in range(2):
        threading.Thread(target=for_ever, daemon=True).start()
    begun.wait()
    to.plan(problem)
"""

WITH_A_PAGE = """
    result = to.plan(problem)
    page = to.view(result, port=0)
    page.play()
"""


def run(tmp_path: Path, ending: str, *, problem: str = "planar_fold", leaks: bool) -> None:
    """Run a program in development mode; anything that it prints is a failure."""
    program = tmp_path / "program.py"
    program.write_text(BEGIN.format(problem=problem) + ending)
    environment = {name: value for name, value in os.environ.items() if name != "TRAJOPT_REPORT_LEAKS"}
    if leaks:
        environment["TRAJOPT_REPORT_LEAKS"] = "1"
    done = subprocess.run(
        [sys.executable, "-X", "dev", "-W", "error::RuntimeWarning", str(program)],
        capture_output=True,
        text=True,
        check=False,
        env=environment,
        timeout=240,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


@pytest.mark.parametrize("ending", ENDINGS.values(), ids=ENDINGS)
def test_nothing_is_leaked(tmp_path: Path, ending: str) -> None:
    """With the report on, which is off for users."""
    run(tmp_path, ending, leaks=True)


def test_nothing_is_leaked_with_a_pandas_meshes(tmp_path: Path) -> None:
    try:
        to.named_problem("cup_past_pillar")
    except to.MissingExtra as missing:
        pytest.skip(str(missing))
    run(tmp_path, "", problem="cup_past_pillar", leaks=True)


def test_the_end_comes_in_the_middle_of_a_plan(tmp_path: Path) -> None:
    """Threads that are inside the native cores then must neither abort the process nor count as leaks."""
    run(tmp_path, WHILE_PLANNING, leaks=False)


def test_a_page_that_was_never_closed(tmp_path: Path) -> None:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    run(tmp_path, WITH_A_PAGE, leaks=True)


def test_importing_warns_of_nothing() -> None:
    """Not even in the name of a package that is imported on the way."""
    modules = "trajopt, trajopt.cli, trajopt.ros.commander, trajopt.simulation, trajopt.viewer"
    command = [sys.executable, "-X", "dev", "-W", "error", "-c", f"import {modules}"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
