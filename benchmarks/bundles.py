"""Replay of bundles, refusal of hostile files with its cost, and reports.

python -m benchmarks.bundles [--replays 50] [--page FILE]

Each hostile file is made in one process and read in another, which begins with trajopt imported and nothing
else; CPU time is of the reading alone, memory the most that the process ever had. Each problem is planned,
kept, read again and replayed.
"""

import argparse
import multiprocessing
import re
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path
from statistics import median
from typing import TypeVar

import trajopt as to
from benchmarks.page import table, write_section
from tests.files.bundle.conftest import members_of, write_members
from tests.files.bundle.hostile import (
    Change,
    Members,
    files,
    of_arrays,
    of_contents,
    of_json,
    of_sizes,
    of_values,
)
from trajopt.files.bundle import read_bundle, replay
from trajopt.problem.problem import named_problem
from trajopt.values.errors import FileFormatError
from trajopt.viewer.report import write_report

MOST_SECONDS, MOST_MEMORY = 2.0, 1024.0
"""What a hostile file may take at most: CPU [s], memory [MiB]."""
GROUPS: Mapping[str, Callable[[], Mapping[str, Change]]] = {
    "invalid documents": of_json,
    "documents with forbidden content": of_contents,
    "invalid arrays": of_arrays,
    "invalid values": of_values,
    "excessive sizes": of_sizes,
}
REPORTED = ("cup_past_pillar", "goal_in_collision")
"""Of the Panda: a plan, and a failure."""
Found = TypeVar("Found")


@dataclass(frozen=True)
class Read:
    """What came of reading a hostile file."""

    name: str
    refused: bool
    seconds: float
    memory: float


@dataclass(frozen=True)
class Kept:
    """What came of a bundle that was replayed."""

    name: str
    same: bool
    size: int
    saved: float
    read: float


def alone(function: Callable[..., Found], *arguments: object) -> Found:
    """Call a function in a process of its own."""
    with multiprocessing.get_context("fork").Pool(1) as pool:
        return pool.apply(function, arguments)


def hostile(members: Members, folder: Path) -> Iterator[tuple[str, str, Path]]:
    """Yield each hostile file with its group and its name; one after the other is in the same place."""
    path = folder / "hostile.trajopt"
    for name in files():
        alone(make_file, name, path, members)
        yield "files that are not bundles", name, path
    for group, changes in GROUPS.items():
        for name in changes():
            alone(change_members, group, name, path, members)
            yield group, name, path


def make_file(name: str, path: Path, members: Members) -> None:
    """Write a file that is not a bundle."""
    files()[name](path, members)


def change_members(group: str, name: str, path: Path, members: Members) -> None:
    """Write a bundle with something changed."""
    changed = dict(members)
    GROUPS[group]()[name](changed)
    write_members(path, changed)


def read_one(name: str, path: Path) -> Read:
    """Read a hostile file, and return the cost."""
    begin = time.process_time()
    try:
        read_bundle(path)
        refused = False
    except FileFormatError:
        refused = True
    seconds = time.process_time() - begin
    status = Path("/proc/self/status").read_text()
    peak = re.search(r"VmHWM:\s+(\d+)", status)
    return Read(name, refused, seconds, int(peak[1]) / 1024.0 if peak else float("nan"))


def replayed(name: str, path: Path) -> Kept:
    """Plan, keep, read and replay a problem."""
    result = to.plan(named_problem(name))
    begin = time.process_time()
    result.save(path)
    saved = time.process_time()
    bundle = read_bundle(path)
    read = time.process_time()
    return Kept(name, replay(bundle).same, path.stat().st_size, saved - begin, read - saved)


def hostile_table(reads: Mapping[str, list[Read]]) -> str:
    """Return a row a group, and one of all."""
    everything = {**reads, "all": [item for group in reads.values() for item in group]}
    rows = [
        (
            name,
            str(len(group)),
            str(sum(item.refused for item in group)),
            f"{max(item.seconds for item in group):.2f} ({max(group, key=lambda item: item.seconds).name})",
            f"{max(item.memory for item in group):.0f} ({max(group, key=lambda item: item.memory).name})",
        )
        for name, group in everything.items()
    ]
    return table(("hostile files", "number", "refused", "most CPU [s]", "most memory [MiB]"), rows)


def replay_table(kept: list[Kept]) -> str:
    """Return the results of replaying."""
    differing = [item.name for item in kept if not item.same]
    rows = [
        ("bundles replayed", str(len(kept))),
        ("same answer to the last digit", str(sum(item.same for item in kept))),
        ("others", ", ".join(differing) or "none"),
        ("size, median / largest", _two([item.size / 1e3 for item in kept], "kB")),
        ("CPU of saving, median / most", _two([1e3 * item.saved for item in kept], "ms")),
        ("CPU of reading, median / most", _two([1e3 * item.read for item in kept], "ms")),
    ]
    return table(("replay", ""), rows)


def report_table(folder: Path) -> str:
    """Return the cost of reports, in a process that has written one before."""
    rows: list[tuple[str, ...]] = []
    for name in REPORTED:
        result = to.plan(named_problem(name))
        result.save(folder / "kept.trajopt")
        bundle = read_bundle(folder / "kept.trajopt", meshes=folder / "meshes")
        for words, moving, pictures in (
            ("3-D and pictures", True, True),
            ("3-D alone", True, False),
            ("neither", False, False),
        ):
            spent, path = list[float](), folder / "report.html"
            for _ in range(3):
                begin = time.process_time()
                write_report(bundle, path, moving=moving, pictures=pictures)
                spent.append(time.process_time() - begin)
            size = path.stat().st_size / 1e6
            rows.append((name, words, f"{size:.2f}", f"{spent[0]:.2f}", f"{min(spent[1:]):.2f}"))
    head = ("report of", "with", "size [MB]", "CPU, the first [s]", "CPU, another [s]")
    return table(head, rows)


def _two(values: list[float], unit: str) -> str:
    return f"{median(values):.0f} / {max(values):.0f} {unit}"


def main() -> None:
    """Measure, print, and write a section of a page."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--replays", type=int, default=50)
    asked.add_argument("--page", type=Path)
    options = asked.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        scene = to.Scene(to.load("planar2")).add("ball", to.Sphere(0.1), to.placement((0.65, 0.65, 0.1)))
        goal = {"joint1": 1.4, "joint2": 0.4}
        problem = to.Problem(scene=scene, start=[0.0, 0.4], goal=goal, name="past a ball")
        alone(keep, problem, folder / "kept.trajopt")
        members = members_of(folder / "kept.trajopt")
        reads = dict[str, list[Read]]()
        for group, name, path in hostile(members, folder):
            reads.setdefault(group, []).append(alone(read_one, name, path))
        names = sorted(entry.name for entry in entry_points(group="trajopt.problems"))[: options.replays]
        kept = [alone(replayed, name, folder / "one.trajopt") for name in names]
        reports = alone(report_table, folder)
    text = "\n\n".join((hostile_table(reads), replay_table(kept), reports))
    print(text)
    if options.page is not None:
        write_section(options.page, "bundles", text)
    worst = [item for group in reads.values() for item in group]
    assert all(item.refused for item in worst), [item.name for item in worst if not item.refused]
    over = [item for item in worst if item.seconds > MOST_SECONDS or item.memory > MOST_MEMORY]
    assert not over, over


def keep(problem: to.Problem, path: Path) -> None:
    """Plan a problem and keep it."""
    to.plan(problem).save(path)


if __name__ == "__main__":
    main()
