"""Processes of the operating system."""

import ctypes
import os
import signal
import sys

DEATH_SIGNAL = 1
"""`PR_SET_PDEATHSIG` of Linux."""


def cores() -> int:
    """Return the number of processor cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):  # on Linux only
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def die_with_parent() -> None:
    """Make the system end this process with its parent, if supported, also during native code."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(DEATH_SIGNAL, signal.SIGKILL)
