"""Check a proof file with the checker, in a Python process that cannot import trajopt's own modules."""

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import trajopt.verify
from trajopt.values.errors import FileFormatError

CHECKER = Path(trajopt.verify.__file__).parent / "checker"
"""The folder of the checker."""
PROVEN, REFUSED = 0, 1


@dataclass(frozen=True)
class CheckedProof:
    """The answer of the checker.

    Attributes:
        proven: Whether the statement is proven.
        words: The statement in words, and PROVEN or the first fault.
    """

    proven: bool
    words: str


def check_proof(path: Path | str) -> CheckedProof:
    """Check a proof file.

    Raises:
        FileFormatError: If the file is not a proof of the format.
    """
    command = [sys.executable, "-I", str(CHECKER), str(path)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode not in (PROVEN, REFUSED):
        raise FileFormatError(
            str(path), run.stderr.strip().splitlines()[-1] if run.stderr.strip() else "is no proof"
        )
    return CheckedProof(run.returncode == PROVEN, run.stdout.rstrip("\n"))
