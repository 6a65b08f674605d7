"""Several writers at once, and a kill in the middle: nothing acknowledged is lost, nothing there by half."""

import os
import sqlite3
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import pytest

from benchmarks.warehouse.killing import ROOT, run
from trajopt.server.warehouse import StoredState, Warehouse


@pytest.mark.timeout(240)
def test_a_kill_in_the_middle_loses_nothing(tmp_path: Path) -> None:
    found = run(tmp_path / "kept.warehouse", writes=40, kills=1, seed=1)
    assert found.acknowledged >= 40 and found.kills == 2
    assert (found.lost, found.half) == (0, 0)
    with closing(sqlite3.connect(tmp_path / "kept.warehouse")) as connection, connection:
        assert connection.execute("PRAGMA integrity_check").fetchone()[0] == "ok"
    connection.close()


def test_threads_of_one_process_take_turns(kept: Warehouse) -> None:
    def write(number: int) -> int:
        return kept.add("home", StoredState("arm", {"joint": float(number)})).version

    with ThreadPoolExecutor(4) as pool:
        versions = list(pool.map(write, range(24)))
    assert sorted(versions) == list(range(1, 25))
    for number, version in enumerate(versions):
        assert kept.state("home", version=version).positions["joint"] == number


@pytest.mark.timeout(120)
def test_two_processes_creating_the_file_together_create_one(tmp_path: Path) -> None:
    path = tmp_path / "new.warehouse"
    begun = [
        subprocess.Popen(
            [sys.executable, "-m", "benchmarks.warehouse.writer", str(path), who, "3"],
            cwd=ROOT,
            stdout=subprocess.DEVNULL,
        )
        for who in ("a", "b")
    ]
    assert [each.wait(timeout=100) for each in begun] == [0, 0]
    with Warehouse(path, create=False) as kept:
        assert len(kept.find()) == 6


FORKED = """
import os, sys
from trajopt.server.warehouse import StoredState, Warehouse

kept = Warehouse(sys.argv[1])
kept.add("before", StoredState("arm", {"joint": 0.0}))
written, closed = os.pipe(), os.pipe()
child = os.fork()
if child == 0:
    kept.add("beside", StoredState("arm", {"joint": 1.0}))
    os.write(written[1], b".")
    os.read(closed[0], 1)
    kept.add("after", StoredState("arm", {"joint": 2.0}))
    os._exit(0)
os.read(written[0], 1)
kept.close()
os.write(closed[1], b".")
assert os.waitpid(child, 0)[1] == 0
print(*sorted(entry.name for entry in kept.find()))
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are not forked here")
def test_a_forked_process_loses_no_entry_when_its_parent_closes_the_file(tmp_path: Path) -> None:
    run_here = [sys.executable, "-c", FORKED, str(tmp_path / "kept.warehouse")]
    told = subprocess.run(run_here, cwd=ROOT, capture_output=True, text=True, timeout=100, check=True)
    assert told.stdout.split() == ["after", "before", "beside"]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are not forked here")
def test_a_forked_process_reopens_the_file(kept: Warehouse) -> None:
    kept.add("home", StoredState("arm", {"joint": 0.0}))
    child = os.fork()
    if child == 0:
        try:
            kept.add("home", StoredState("arm", {"joint": 1.0}))
            os._exit(0)
        except BaseException:
            os._exit(1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    kept.add("home", StoredState("arm", {"joint": 2.0}))
    assert [entry.version for entry in kept.find()] == [3, 2, 1]
