"""Run a script with bounds on CPU time and memory, and without write access to files.

Started as a script itself: `python bounded_child.py SCRIPT SECONDS BYTES`.
"""

import runpy
import sys


def bound(seconds: int, memory: int) -> None:
    """Limit CPU time [s] and address space [bytes] of this process, and forbid it files; not on Windows."""
    try:
        import resource
    except ModuleNotFoundError:
        return
    for limit, most in (
        (resource.RLIMIT_CPU, seconds),
        (resource.RLIMIT_AS, memory),
        (resource.RLIMIT_FSIZE, 0),
        (resource.RLIMIT_CORE, 0),
    ):
        resource.setrlimit(limit, (most, most))


if __name__ == "__main__":
    _, script, seconds_given, memory_given = sys.argv
    bound(int(seconds_given), int(memory_given))
    runpy.run_path(script, run_name="__main__")
