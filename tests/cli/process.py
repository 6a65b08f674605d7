"""The command line as a process, in which nothing but what trajopt says may be printed."""

import subprocess
import sys
from pathlib import Path

STRICT = ("-X", "dev", "-W", "error::RuntimeWarning")
"""Python's development mode, which shows every warning, and what is left open at the end."""
OURS = "trajopt: "


def trajopt(*words: object, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run a command; on standard error it may say one thing, what is wrong with what it was given.

    Args:
        words: The command and its arguments.
        folder: Where it runs; here when None.
    """
    command = [sys.executable, *STRICT, "-m", "trajopt", *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False, cwd=folder)
    said = done.stderr.splitlines()
    if done.returncode == 2:
        assert said and (said[0].startswith((OURS, "Usage: "))), done.stderr
        said = [] if said[0].startswith("Usage: ") else said[1:]
    assert not said, done.stderr
    return done
