"""Campaigns ended from outside: no process is left behind, and they go on."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.lab.campaign.rooms import rows_of
from trajopt.lab.campaign import CampaignFolder, Local, resume_campaign

pytestmark = [
    pytest.mark.timeout(240),
    pytest.mark.skipif(sys.platform != "linux", reason="processes are listed in /proc"),
]
RUN = (sys.executable, "-m", "trajopt", "campaign", "run", "random", "--robot", "planar2", "--count", "400")


def children(pid: int) -> set[int]:
    """Return the ids of the processes that a process started."""
    found: set[int] = set()
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[1]) == pid:
            found.add(int(stat.parent.name))
    return found


def alive(pid: int) -> bool:
    """Say whether a process runs; one that nobody has waited for yet does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.fixture
def running(tmp_path: Path) -> Iterator[tuple["subprocess.Popen[str]", set[int]]]:
    """A campaign that has written its first rows, and its workers."""
    command = (*RUN, "--out", str(tmp_path / "out"), "--workers", "2")
    # What tests run in the background are deaf to, whatever they start is deaf to as well.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    signal.signal(signal.SIGINT, before)
    try:
        while not list((tmp_path / "out" / "results").glob("[!.]*.parquet")):
            assert process.poll() is None, process.communicate()
            time.sleep(0.02)
        yield process, children(process.pid)
    finally:
        process.kill()
        process.communicate()


def gone(pids: set[int]) -> bool:
    """Wait until processes have ended."""
    until = time.monotonic() + 60.0
    while any(map(alive, pids)) and time.monotonic() < until:
        time.sleep(0.05)
    return not any(map(alive, pids))


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_campaign_exits_cleanly_and_resumes(
    running: tuple["subprocess.Popen[str]", set[int]], tmp_path: Path, how: signal.Signals
) -> None:
    process, workers = running
    assert workers
    process.send_signal(how)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130 and "Traceback" not in said, said
    assert re.search(r"interrupted: \d+ of 400 rows", said) and "campaign resume" in said
    assert gone(workers)
    folder = CampaignFolder.open(tmp_path / "out")
    done = len(folder.done())
    assert 0 < done < 400
    assert len(rows_of(resume_campaign(folder.path, Local(2)))) == 400


def test_a_killed_campaign_leaves_no_process_and_resumes(
    running: tuple["subprocess.Popen[str]", set[int]], tmp_path: Path
) -> None:
    process, workers = running
    assert workers
    os.kill(process.pid, signal.SIGKILL)
    process.communicate(timeout=60)
    assert gone(workers)
    folder = CampaignFolder.open(tmp_path / "out")
    assert len(folder.done()) < 400
    rows = rows_of(resume_campaign(folder.path, Local(2)))
    assert len(rows) == 400 and all(row["verified"] for row in rows.values())


def test_a_killed_worker_costs_nothing(
    running: tuple["subprocess.Popen[str]", set[int]], tmp_path: Path
) -> None:
    process, workers = running
    os.kill(min(workers), signal.SIGKILL)
    said, complained = process.communicate(timeout=200)
    assert process.returncode == 0, complained
    rows = rows_of(CampaignFolder.open(tmp_path / "out"))
    assert len(rows) == 400 and all(row["verified"] for row in rows.values()), said
