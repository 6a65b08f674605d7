"""Memory of a process: how much it has, and a bound on what it may take."""

import os
import resource
import sys
from pathlib import Path

KILOBYTE = 2**10


def memory_used(pid: int | None = None) -> int:
    """Return what a process has in memory [bytes]; 0 where the system does not say.

    Args:
        pid: Its id; this process when None.
    """
    return _pages(pid or os.getpid(), 1)


def limit_memory(more: int) -> None:
    """Let this process take so much more memory than it has now, and no more: then it gets a `MemoryError`.

    Each call counts anew, and takes the place of the one before.

    Systems other than Linux do not bound it.

    Args:
        more: How much more [bytes].
    """
    if sys.platform == "linux":
        # What is only reserved, as by the stacks of threads, does not count: so data, not address space.
        bound, (_, hard) = _pages(os.getpid(), 5) + more, resource.getrlimit(resource.RLIMIT_DATA)
        resource.setrlimit(resource.RLIMIT_DATA, (bound if hard < 0 else min(bound, hard), hard))


def _pages(pid: int, column: int) -> int:
    """Return a column of Linux' table of a process's memory [bytes]; 0 where there is none."""
    try:
        columns = Path(f"/proc/{pid}/statm").read_text().split()
    except OSError:
        return 0
    return int(columns[column]) * resource.getpagesize()
