"""Two versions of trajopt side by side: the same problems in turn, one core, CPU time of the whole `plan()`.

python -m benchmarks.versions DATA --old PYTHON [--limit K] [--json FILE] [--page FILE]

PYTHON is the interpreter of an environment in which the old version is installed. Each version plans in a
process of its own; the problems take turns, and so does who goes first.
"""

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.motion_bench_maker import in_turn, listed
from benchmarks.page import table, write_section

ROBOTS = {"panda": "Panda", "ur5": "UR5", "fetch": "Fetch", "baxter": "Baxter"}
STAGES = ("examine", "seed", "optimise", "retime", "verify")
HEAD = (
    "robot", "problems", "verified old", "verified new", "CPU ms old median / p90", "new", "new / old",
    "duration, median ratio", "distance calls, median old", "new",
)  # fmt: skip
Answer = dict[str, Any]


class Version:
    """A process that plans with one version."""

    def __init__(self, python: str, data: Path) -> None:
        """Start it.

        Args:
            python: Its interpreter.
            data: Folder of the problems.
        """
        script = str(Path(__file__).with_name("planning_worker.py").resolve())
        self._process = subprocess.Popen(
            [python, script, str(data)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=Path(python).parent,
            env=os.environ | {"OMP_NUM_THREADS": "1"},
        )

    def plan(self, key: str) -> Answer:
        """Plan a problem and return its outcome."""
        to_it, from_it = self._process.stdin, self._process.stdout
        if to_it is None or from_it is None:
            raise RuntimeError("the pipes of a started process are there")
        print(key, file=to_it, flush=True)
        line = from_it.readline()
        if not line:
            raise SystemExit(f"{self._process.args} ended at {key}")
        return json.loads(line)


def compared(data: Path, old: str, robots: Sequence[str], limit: int | None) -> list[tuple[Answer, Answer]]:
    """Plan all problems with both versions, after one of each robot that is not counted."""
    versions = Version(old, data), Version(sys.executable, data)
    keys = in_turn({name: listed(data / name, limit) for name in robots})
    for name in robots:
        family, number = next(key for key in keys if key[0].startswith(f"{name}/"))
        for version in versions:
            version.plan(f"{family}/{number}")
    found: list[tuple[Answer, Answer]] = []
    for turn, (family, number) in enumerate(keys):
        order = (0, 1) if turn % 2 else (1, 0)
        answers = {which: versions[which].plan(f"{family}/{number}") for which in order}
        found.append((answers[0], answers[1]))
    return found


def row(name: str, both: Sequence[tuple[Answer, Answer]]) -> list[str]:
    """Return a robot's row of the table."""
    old, new = (np.array([pair[side]["ms"] for pair in both]) for side in (0, 1))
    solved = [[pair[side]["status"] == "SOLVED" for pair in both] for side in (0, 1)]
    longer = [new["duration"] / old["duration"] for old, new in both if old["duration"] and new["duration"]]
    calls = [np.median([pair[side]["counts"].get("distance_calls", 0) for pair in both]) for side in (0, 1)]
    parts = [np.percentile(side, (50, 90)) for side in (old, new)]
    return [
        name,
        str(len(both)),
        *(str(sum(side)) for side in solved),
        *(f"{median:.1f} / {high:.1f}" for median, high in parts),
        " / ".join(f"{after / before:.2f}" for before, after in zip(*parts, strict=True)),
        f"{np.median(longer):.4f}" if longer else "",
        *(f"{count:.0f}" for count in calls),
    ]


def stages(both: Sequence[tuple[Answer, Answer]]) -> list[list[str]]:
    """Return the median CPU time of each stage, old and new, over all problems."""
    rows: list[list[str]] = []
    for stage in STAGES:
        old, new = (np.median([pair[side]["stages"].get(stage, 0.0) for pair in both]) for side in (0, 1))
        rows.append([stage, f"{old:.1f}", f"{new:.1f}", f"{new / max(old, 1e-9):.2f}"])
    return rows


def main() -> None:
    """Measure and write the section."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--old", required=True, help="interpreter of the old version's environment")
    parser.add_argument("--limit", type=int, help="problems of each set at most")
    parser.add_argument("--json", type=Path, default=Path("benchmarks/results/versions.json"))
    parser.add_argument("--page", type=Path, help="Markdown file with the section's markers")
    given = parser.parse_args()
    both = compared(given.data.resolve(), given.old, tuple(ROBOTS), given.limit)
    of_robot = {name: [pair for pair in both if pair[0]["key"].startswith(f"{name}/")] for name in ROBOTS}
    rows = [row(ROBOTS[name], pairs) for name, pairs in of_robot.items()]
    text = table(HEAD, rows) + "\n\n" + table(["stage", "CPU ms old", "new", "new / old"], stages(both))
    print(text)
    given.json.parent.mkdir(parents=True, exist_ok=True)
    lines = ",\n".join(json.dumps({"old": old, "new": new}) for old, new in both)
    given.json.write_text(f"[\n{lines}\n]\n")
    if given.page is not None:
        write_section(given.page, "versions", text)


if __name__ == "__main__":
    main()
