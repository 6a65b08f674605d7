"""Processes: their cores and end, and children with bounds that read untrusted files."""

import ctypes
import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

SECONDS, MEMORY = 30, 2**32
"""Largest CPU time [s] and address space [bytes]: ten times the need of the largest real robots."""
REFUSED = 3
"""Exit status of a script that refuses a request; its standard output is the reason."""
DEATH_SIGNAL = 1
"""`PR_SET_PDEATHSIG` of Linux."""
_CHILD = Path(__file__).with_name("bounded_child.py")
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


class ProcessRefused(Exception):
    """The process returned no answer; the message is the reason."""


def answer_of(
    script: Path,
    request: bytes,
    *,
    environment: Mapping[str, str] | None = None,
    seconds: int = SECONDS,
    memory: int = MEMORY,
) -> bytes:
    """Return the answer of a script that reads a request from standard input.

    Args:
        script: Writes its answer to standard output and exits with 0, or writes the reason and exits with
            `REFUSED`.
        environment: As in this process if None.

    Raises:
        ProcessRefused: If the script refuses, exceeds a limit, or crashes.
    """
    known = os.environ if environment is None else environment
    try:
        done = subprocess.run(
            [sys.executable, "-I", str(_CHILD), str(script), str(seconds), str(memory)],
            input=request,
            capture_output=True,
            timeout=2.0 * seconds,
            env={**known, **_ONE_THREAD},
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise ProcessRefused(f"reading it takes more than {2 * seconds} s") from error
    if done.returncode == 0:
        return done.stdout
    if done.returncode == REFUSED:
        raise ProcessRefused(done.stdout.decode(errors="replace"))
    if -done.returncode in (getattr(signal, "SIGXCPU", None), getattr(signal, "SIGKILL", None)):
        raise ProcessRefused(f"reading it takes more than {seconds} s of CPU time, or too much memory")
    if done.returncode < 0:
        raise ProcessRefused(f"it crashes its reader ({signal.Signals(-done.returncode).name})")
    said = done.stderr.decode(errors="replace").strip().splitlines()
    if (said and said[-1].startswith("MemoryError")) or b"bad_alloc" in done.stderr:
        raise ProcessRefused(f"reading it takes more than {memory / 2**30:g} GB of memory")
    raise ProcessRefused(f"it cannot be read: {said[-1] if said else f'exit status {done.returncode}'}")


def start_worker(module: str, *ends: int) -> "subprocess.Popen[bytes]":
    """Start a module as a process with one thread for libraries, and files inherited by their numbers."""
    return subprocess.Popen(
        [sys.executable, "-m", module, *map(str, ends)],
        pass_fds=ends,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        start_new_session=True,  # the terminal's Ctrl-C is for the parent, which ends its workers
        env={**os.environ, **_ONE_THREAD, "PYTHONPATH": os.pathsep.join(sys.path)},
    )


def cores() -> int:
    """Return the number of processor cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):  # on Linux only
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def die_with_parent() -> None:
    """Make the system end this process with its parent, if supported, also during native code."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(DEATH_SIGNAL, signal.SIGKILL)
