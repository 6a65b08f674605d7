"""Write the versions with which the checks and tests pass: `python packaging/lock.py packaging/locked.txt`.

What pip would install today of everything that the project names, pinned; `make` installs these. Run it with
the oldest Python that is supported: what it chooses is there for the newer ones too.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

OLDEST = (3, 11)
WANTED = ".[dev,docs,notebooks,descriptions,ur]"
HEAD = "# Versions with which the checks and tests pass, for pip's --constraint; by packaging/lock.py.\n"
OWN = "trajopt-planner"


def resolved() -> list[str]:
    """Return each package that pip would install, with its version."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.json"
        asked = ["install", "--quiet", "--dry-run", "--ignore-installed", "--report", str(report), WANTED]
        subprocess.run([sys.executable, "-m", "pip", *asked], check=True)
        found = [each["metadata"] for each in json.loads(report.read_text())["install"]]
    return sorted(f"{each['name']}=={each['version']}".lower() for each in found if each["name"] != OWN)


def main(path: Path) -> None:
    """Write them to a file."""
    if sys.version_info[:2] != OLDEST:
        sys.exit(f"run it with Python {OLDEST[0]}.{OLDEST[1]}, which is the oldest that is supported")
    path.write_text(HEAD + "".join(f"{line}\n" for line in resolved()))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
