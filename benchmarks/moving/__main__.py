"""Dynamic obstacles: crossing boxes, bouncing cubes, and baselines, with one judge.

python -m benchmarks.moving DATA [--parts crossing,known,cubes,best] [--every N] [--tests N] [--page FILE]

crossing   each N-th problem of `crossings.py`, less those of `fixed_links.py`: the still problem, ours among
           what moves, and waiting
known      the baseline where neither ours nor waiting has a motion, and none is proven impossible
cubes      the first N tests of `cubes.py` at each density: ours, then the baseline with ten times our CPU
best       the baseline, ever shorter, on each 20th, or other, of the problems that cross (of those asked in
           `crossing`)

Rows are kept in --out; what has one there is not asked again, unless its process died or its part is
named in --anew. What `known` and `best` ask does not depend on ours. Build and change nothing meanwhile.
"""

import argparse
import json
import subprocess
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from benchmarks.moving.asking import BEST, CROSSING, CUBES, KNOWN, PARTS, ask, prepare
from benchmarks.moving.crossings import ROBOTS, crossings
from benchmarks.moving.cubes import DENSITIES
from benchmarks.moving.fixed_links import not_askable
from benchmarks.moving.report import Report
from benchmarks.page import write_section
from benchmarks.rows import Rows
from benchmarks.workers import Key, Row
from benchmarks.workers import run as run_all


def main() -> None:
    """Plan the problems without a row, and write the tables of all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--parts", default=",".join(PARTS), help="names, separated by commas")
    parser.add_argument("--robots", default=",".join(ROBOTS), help="of the boxes that cross")
    parser.add_argument("--every", type=int, default=1, help="each so many-th of the problems that cross")
    parser.add_argument("--tests", type=int, default=50, help="of each number of cubes")
    parser.add_argument("--densities", default=",".join(map(str, DENSITIES)), help="numbers of cubes")
    parser.add_argument("--best-every", type=int, default=20, help="each so many-th, for the best")
    parser.add_argument("--known-seconds", type=float, default=20.0, help="CPU time of the baseline")
    parser.add_argument("--best-seconds", type=float, default=60.0, help="CPU time of the baseline")
    parser.add_argument("--out", type=Path, default=Path("out/moving"), help="folder of the rows")
    parser.add_argument("--anew", default="", help="parts whose rows are dropped first")
    parser.add_argument("--workers", type=int, default=1, help="processes; more than one disturb each other")
    parser.add_argument("--seconds", type=float, default=1800.0, help="wall-clock time of a problem at most")
    parser.add_argument("--results", type=Path, help="file for the rows' numbers")
    parser.add_argument("--page", type=Path, help="Markdown file with the section's markers")
    given = parser.parse_args()
    parts = [name for name in given.parts.split(",") if name]
    if unknown := set(parts) - set(PARTS):
        parser.error(f"no such part: {', '.join(sorted(unknown))}; there are {', '.join(PARTS)}")
    if given.anew:
        drop(given.out / "rows.jsonl", given.anew.split(","))
    rows, commit = Rows(given.out / "rows.jsonl"), _commit()
    robots = [name for name in given.robots.split(",") if name]
    chosen = crossing_keys(robots, given.every)
    rooms = [(f"{CUBES}/{count}", test) for test in range(given.tests) for count in _counts(given.densities)]

    def asked(keys: Sequence[Key], seconds: float, names: Sequence[str]) -> None:
        missing = [key for key in keys if not finished(rows.done.get(_name(key)))]
        print(f"{len(keys)} problems, {len(keys) - len(missing)} of them done before", flush=True)
        run_all(
            missing, ask=partial(ask, given.data.resolve(), seconds), workers=given.workers,
            seconds=given.seconds, keep=lambda row: rows.append(row | {"commit": commit}),
            prepare=partial(prepare, given.data.resolve(), tuple(names)),
        )  # fmt: skip

    if CROSSING in parts:
        asked(chosen, 0.0, robots)
    if KNOWN in parts:
        open_keys = [key for key in chosen if unsettled(rows.done.get(_name(key)))]
        asked([_renamed(key, KNOWN) for key in open_keys], given.known_seconds, robots)
    if CUBES in parts:
        asked(rooms, 0.0, ("xarm7",))
    if BEST in parts:
        few = [key for key in crossing_keys(ROBOTS, given.best_every) if key in set(chosen)]
        asked([_renamed(key, BEST) for key in few], given.best_seconds, robots)
    report = Report(rows.done, chosen, rooms)
    text = report.text()
    print(text)
    if given.results is not None:
        given.results.write_text("".join(f"{json.dumps(row)}\n" for row in report.rows))
    if given.page is not None:
        write_section(given.page, "moving", text)


def finished(row: Row | None) -> bool:
    """Return whether a problem is done; one whose process died is planned again."""
    return row is not None and row["outcome"] == "done"


def drop(file: Path, parts: Sequence[str]) -> None:
    """Drop the rows of parts."""
    lines = file.read_text().splitlines(keepends=True) if file.exists() else []
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("".join(line for line in lines if json.loads(line)["family"].split("/")[0] not in parts))


def crossing_keys(robots: Sequence[str], every: int) -> list[Key]:
    """Return the problems that cross: each so many-th of all, of these robots, that can be asked."""
    found: list[Key] = []
    for key in list(crossings())[::every]:
        robot, name, number = key.split("/")
        if robot in robots and key not in not_askable():
            found.append((f"{CROSSING}/{robot}/{name}", int(number)))
    return found


def _commit() -> str:
    """Return the commit that is measured, with a plus where files differ from it."""
    asked = ("git", "describe", "--always", "--dirty=+", "--exclude=*")
    folder = Path(__file__).parent
    return subprocess.run(asked, cwd=folder, check=False, capture_output=True, text=True).stdout.strip()


def _counts(text: str) -> list[int]:
    return [int(word) for word in text.split(",") if word]


def _name(key: Key) -> str:
    return f"{key[0]}-{key[1]}"


def _renamed(key: Key, part: str) -> Key:
    return key[0].replace(CROSSING, part, 1), key[1]


def unsettled(row: dict[str, object] | None) -> bool:
    """Say whether neither ours nor waiting has a motion, and it is not proven that there is none."""
    if row is None or not isinstance(ours := row.get("ours"), dict):
        return False
    return not ours["verified"] and ours.get("certainty") != "PROVEN" and row.get("wait") is None


if __name__ == "__main__":
    main()
