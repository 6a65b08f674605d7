"""An environment of its own for every planner, and a process of its own for every run."""

import hashlib
import json
import os
import subprocess
import sys
import time
import venv
from dataclasses import dataclass
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
GRACE = 40.0
"""A problem that takes longer than its limit by so much ends the process [s]."""
POLL = 0.2


@dataclass(frozen=True)
class Peer:
    """A planner that is compared.

    Attributes:
        label: Its name in the table.
        worker: Name of its worker, `<worker>_worker.py`, and of its requirements, `<worker>.txt`.
        modules: What must import.
        variant: Passed to the worker.
        note: What a reader of the table has to know of its settings.
    """

    label: str
    worker: str
    modules: tuple[str, ...]
    note: str
    variant: str = ""


def prepare(peer: Peer, folder: Path) -> tuple[Path, str]:
    """Make a planner's environment, unless it is there.

    Returns:
        Its interpreter, and why the planner cannot be used; empty if it can.
    """
    requirements = HERE / f"{peer.worker}.txt"
    if not requirements.exists():
        return Path(sys.executable), ""
    python = folder / "bin" / "python"
    stamp = folder / ".installed"
    wanted = hashlib.sha256(requirements.read_bytes()).hexdigest()
    if not stamp.exists() or stamp.read_text() != wanted:
        venv.create(folder, with_pip=True, clear=True)
        install = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        done = subprocess.run([*install, "-r", requirements], capture_output=True, text=True, check=False)
        if done.returncode:
            return python, f"does not install here: {_last_line(done.stderr)}"
        stamp.write_text(wanted)
    for module in peer.modules:
        done = subprocess.run([python, "-c", f"import {module}"], capture_output=True, text=True, check=False)
        if done.returncode:
            return python, f"wheel does not import here: {_last_line(done.stderr)}"
    return python, ""


def _last_line(text: str) -> str:
    """Return the last line of an error, with file names in place of paths."""
    lines = [line for line in text.strip().splitlines() if line.strip()]
    words = (lines[-1] if lines else "no message").split()
    return " ".join(Path(word).name if "/" in word else word for word in words)


def run(
    peer: Peer, python: Path, problems: Path, results: Path, *, time_limit: float
) -> list[dict[str, Any]]:
    """Run a planner on all problems, in one process; where that ends or hangs, a new one goes on.

    Returns:
        One result for each problem.
    """
    count = len(json.loads(problems.read_text())["problems"])
    log_file = results.with_suffix(".log")
    for file in (results, log_file):
        file.unlink(missing_ok=True)
    done = 0
    while done < count:
        command = [python, HERE / f"{peer.worker}_worker.py", problems, results, str(done), peer.variant]
        with log_file.open("a") as log:
            process = subprocess.Popen(command, stdout=log, stderr=log, cwd=HERE, env=_environment())
            reason = _watch(process, results, time_limit + GRACE)
        done = _lines(results)
        if done < count:
            with results.open("a") as lines:
                lines.write(json.dumps(_lost(reason)) + "\n")
            done += 1
    return [json.loads(line) for line in results.read_text().splitlines()]


def _watch(process: subprocess.Popen[bytes], results: Path, patience: float) -> str:
    """Wait until a process ends, or end it where it writes nothing for too long; say why it ended."""
    size, since = _size(results), time.monotonic()
    while process.poll() is None:
        time.sleep(POLL)
        if _size(results) > size:
            size, since = _size(results), time.monotonic()
        elif time.monotonic() - since > patience:
            process.kill()
            process.wait()
            return f"ended after {patience:g} s"
    return f"the process ended with {process.returncode}"


def _size(path: Path) -> int:
    return path.stat().st_size if path.exists() else 0


def _lines(path: Path) -> int:
    return path.read_text().count("\n") if path.exists() else 0


def _lost(reason: str) -> dict[str, Any]:
    return {
        "claimed": False,
        "path": None,
        "motion": None,
        "message": reason,
        "loading_cpu": None,
        "setup_cpu": None,
        "path_cpu": None,
        "timing_cpu": None,
    }


def _environment() -> dict[str, str]:
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS")
    return {**os.environ, **dict.fromkeys(names, "1")}


def versions(peer: Peer) -> dict[str, str]:
    """Return the versions that a planner's requirements pin."""
    requirements = HERE / f"{peer.worker}.txt"
    lines = requirements.read_text().split() if requirements.exists() else []
    return dict(line.split("==") for line in lines)
