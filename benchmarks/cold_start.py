"""CPU time of a new process: import, load, first plan, second plan, and a command.

python -m benchmarks.cold_start DATA [--old PYTHON] [--rounds 7] [--page FILE]

Every number is of processes of their own, which take turns: this version, and with OLD that of another
interpreter's environment. CPU time is what the system says that a process used, user and system together,
with one thread. Sources are compiled to bytecode once before, as an installation does. The least of all
rounds counts: whatever else runs on a machine only adds to it.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.page import table, write_section

FIRST_AND_SECOND = """
import json, time
begin = time.process_time()
import trajopt as to
imported = time.process_time()
robot = to.load("panda")
loaded = time.process_time()

def problem(x, turn):
    scene = to.Scene(robot).add("post", to.Sphere(0.1), to.placement((x, 0.1, 0.7)))
    goal = to.joint_positions(dict(robot.state("ready")) | {"panda_joint1": turn})
    return to.Problem(scene=scene, group="panda_arm", start="ready", goal=goal)

first, second = problem(0.5, 0.8), problem(0.45, -0.9)
times = [time.process_time()]
for asked in (first, second):
    assert to.plan(asked).verified
    times.append(time.process_time())
print(json.dumps([imported - begin, loaded - imported, times[1] - times[0], times[2] - times[1]]))
"""
STEPS = (
    "`import trajopt`",
    'then `to.load("panda")`',
    "then the first plan",
    "then the second, in another scene",
)
INSTANCE = ("panda/bookshelf_small", "0001")


@dataclass(frozen=True)
class Version:
    """An interpreter in whose environment trajopt is installed.

    Attributes:
        python: The interpreter.
        bytecode: Folder of its bytecode.
    """

    python: str
    bytecode: Path

    def run(self, words: Sequence[str]) -> tuple[float, str]:
        """Run Python with some arguments; return the CPU time of the process [s] and what it printed.

        Raises:
            SystemExit: If it fails.
        """
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(
            [self.python, *words],
            capture_output=True,
            text=True,
            cwd=Path(self.python).parent,
            env=self._environment,
            check=False,
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode:
            raise SystemExit(f"{self.python} {' '.join(words)[:80]}: {done.stderr or done.stdout}")
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done.stdout

    @property
    def _environment(self) -> Mapping[str, str]:
        kept = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
        return kept | {"OMP_NUM_THREADS": "1", "PYTHONPYCACHEPREFIX": str(self.bytecode)}


def command(data: Path) -> list[str]:
    """Return the arguments of `trajopt plan` on files."""
    folder, number = data / INSTANCE[0], INSTANCE[1]
    files = (
        "--scene",
        str(folder / f"scene{number}.yaml"),
        "--request",
        str(folder / f"request{number}.yaml"),
    )
    return ["-m", "trajopt", "plan", "--robot", "panda", *files]


def measured(version: Version, data: Path) -> list[float]:
    """Return the CPU times of the steps of one process, and of `trajopt plan` as a whole [s]."""
    _, steps = version.run(["-c", FIRST_AND_SECOND])
    return [*json.loads(steps), version.run(command(data))[0]]


def rows(found: Sequence[Sequence[Sequence[float]]]) -> list[list[str]]:
    """Return the table's rows: the least of each number, of each version, and their ratio."""
    least = [[min(column) for column in zip(*rounds, strict=True)] for rounds in found]
    lines: list[list[str]] = []
    for what, *values in zip((*STEPS, "`trajopt plan` on files, the whole process"), *least, strict=True):
        ratio = [f"{values[0] / values[1]:.2f}"] if len(values) > 1 else []
        lines.append([what, *(f"{1e3 * value:.0f}" for value in values), *ratio])
    ratios = [each[2] / each[3] for each in least]
    lines.append(["first plan / second", *(f"{value:.2f}" for value in ratios), *([""] * (len(ratios) > 1))])
    return lines


def main() -> None:
    """Measure and write the section."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--old", help="interpreter of an older version's environment")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--page", type=Path, help="Markdown file with the section's markers")
    given = parser.parse_args()
    data = given.data.resolve()
    with tempfile.TemporaryDirectory() as scratch:
        pythons = [sys.executable, *([given.old] if given.old else [])]
        versions = [Version(python, Path(scratch) / str(place)) for place, python in enumerate(pythons)]
        for version in versions:
            measured(version, data)  # writes the bytecode
        found: list[list[list[float]]] = [[] for _ in versions]
        for _ in range(given.rounds):
            for version, so_far in zip(versions, found, strict=True):
                so_far.append(measured(version, data))
    head = (
        "CPU ms, the least of the rounds",
        "this version",
        *(("older", "this / older") if given.old else ()),
    )
    text = table(head, rows(found))
    print(text)
    if given.page is not None:
        write_section(given.page, "cold_start", text)


if __name__ == "__main__":
    main()
