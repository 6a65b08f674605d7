"""A cluster of Ray on one machine: a head that does not plan and nodes of one core each."""

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

RAY = (sys.executable, "-m", "ray.scripts.scripts")
PORT, STARTS = 6397, 4
COMMON = ("--node-ip-address=127.0.0.1", "--disable-usage-stats", "--include-log-monitor=false")
"""Logs are not sent to the driver, which does not ask for them: one process less of each node."""
AS_OTHERS = {"RAY_worker_niceness": "0"}
"""Ray gives its workers what other processes leave: on a machine with others a run would take many times as
long, and Ray's own processes with it, which work as long as it lasts."""


@dataclass(frozen=True)
class Cluster:
    """A running cluster.

    Attributes:
        address: Where its head is.
        folder: Where it keeps its files.
    """

    address: str
    folder: Path

    def raylets(self) -> list[int]:
        """Return the ids of the nodes' processes, that of the head first."""
        found = [pid for pid, line in processes() if "raylet/raylet" in line and str(self.folder) in line]
        return sorted(found, key=lambda pid: int((status(pid) or ["0"] * 20)[19]))

    def add(self) -> None:
        """Start a node of one core."""
        start(f"--address={self.address}", "--num-cpus=1", *COMMON)

    def mine(self) -> list[int]:
        """Return the ids of all of its processes, and of the workers that its actors watch."""
        own = {pid for pid, line in processes() if str(self.folder) in line or line.startswith("ray::")}
        return [*own, *(pid for pid, _ in processes() if parent(pid) in own and pid not in own)]


@contextmanager
def cluster(folder: Path, nodes: int = 2) -> Generator[Cluster]:
    """Start a cluster, and end it."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    head = ("--head", "--num-cpus=0", f"--port={PORT}", "--include-dashboard=false")
    head = (*head, f"--temp-dir={folder.resolve()}")
    try:
        start(*head, *COMMON, ended=folder.resolve())
        running = Cluster(f"127.0.0.1:{PORT}", folder.resolve())
        for _ in range(nodes):
            running.add()
        yield running
    finally:
        end(folder.resolve())


def end(folder: Path) -> None:
    """Kill all processes of the cluster that keeps its files in a folder."""
    for pid in Cluster("", folder).mine():
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            pass


def start(*words: str, ended: Path | None = None) -> None:
    """Start a head or a node: Ray gives up after half a minute, which a busy machine may take."""
    said = ""
    for _ in range(STARTS):
        command = (*RAY, "start", *words)
        env = {**os.environ, **AS_OTHERS}
        done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False, env=env)
        if done.returncode == 0:
            return
        said = f"{done.stdout}{done.stderr}"
        if ended is not None:
            end(ended)  # what is left of the head would answer for the next
    raise SystemExit(f"ray start failed: {said}")


def processes() -> list[tuple[int, str]]:
    """Return the ids and command lines of all processes."""
    found: list[tuple[int, str]] = []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            line = (path / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
        except OSError:
            continue
        found.append((int(path.name), line))
    return found


def parent(pid: int) -> int:
    """Return the id of the process that started a process; 0 where it has ended."""
    fields = status(pid)
    return int(fields[1]) if fields else 0


def status(pid: int) -> list[str]:
    """Return the fields of /proc/PID/stat after the process name; empty if it has ended."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return []


def cpu_seconds(pid: int) -> float:
    """Return the process time of a process, its own alone [s]."""
    fields = status(pid)
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK") if fields else 0.0


def memory(pid: int) -> float:
    """Return the resident memory of a process [MB]."""
    fields = status(pid)
    return int(fields[21]) * os.sysconf("SC_PAGE_SIZE") / 2**20 if fields else 0.0


def workers(of: set[int]) -> list[int]:
    """Return the ids of the processes that plan, of those that some processes started."""
    return [pid for pid, line in processes() if "trajopt.lab.campaign.worker" in line and parent(pid) in of]
