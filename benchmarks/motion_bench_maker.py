"""MotionBenchMaker on four robots: success on answerable problems, CPU time by stage, exact counts.

python -m benchmarks.motion_bench_maker DATA [--robots fetch,baxter] [--limit K] [--page FILE]

DATA holds <robot>/<set>/ (scenes and requests in MoveIt's YAML) for a Panda, a UR5, a Fetch and a Baxter, and
<robot>/robot/ for all but the Panda, as they were found. The robots' problems take turns, so that what else
the machine does hits all alike, in a process of its own that a clock watches: one that hangs is ended and
counted. Rows are kept in --out; what has one there is not planned again: delete them to measure anew.
"""

import argparse
import time
import traceback
from collections.abc import Sequence
from functools import cache, partial
from pathlib import Path

import trajopt as to
from benchmarks.rows import Rows
from benchmarks.sections import write_results
from benchmarks.workers import Row
from benchmarks.workers import run as run_all
from trajopt.lab.suite import Instance, run
from trajopt.lab.suite.instance import find_instances

ROBOTS = ("panda", "ur5", "fetch", "baxter")


def main() -> None:
    """Plan the problems without a row, and write tables and results of all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--robots", default=",".join(ROBOTS), help="names, separated by commas")
    parser.add_argument("--limit", type=int, help="problems of each set at most")
    parser.add_argument("--out", type=Path, default=Path("out/bench"), help="folder of the rows")
    parser.add_argument("--workers", type=int, default=1, help="processes; more than one disturb each other")
    parser.add_argument("--seconds", type=float, default=60.0, help="wall-clock time of one problem at most")
    parser.add_argument("--results", type=Path, help="folder for the robots' numbers")
    parser.add_argument("--page", type=Path, help="Markdown file with the sections' markers")
    given = parser.parse_args()
    robots = [name for name in given.robots.split(",") if name]
    keys = in_turn({name: listed(given.data / name, given.limit) for name in robots})
    rows = Rows(given.out / "rows.jsonl")
    missing = [key for key in keys if row_name(*key) not in rows.done]
    print(f"{len(keys)} problems, {len(keys) - len(missing)} of them done before", flush=True)
    run_all(
        missing, ask=partial(ask, given.data), workers=given.workers, seconds=given.seconds, keep=rows.append,
        prepare=partial(prepare, given.data, robots),
    )  # fmt: skip
    found = {
        name: [rows.done[row_name(*key)] for key in keys if key[0].startswith(f"{name}/")] for name in robots
    }
    write_results(given.data, found, seconds=given.seconds, results=given.results, page=given.page)


def listed(folder: Path, limit: int | None) -> list[tuple[str, int]]:
    """Return the problems of a robot: robot/set and number, the sets in turn."""
    sets = sorted({scene.parent for scene in folder.glob("*/scene*.yaml")})
    if not sets:
        raise SystemExit(f"{folder} holds no <set>/sceneNNNN.yaml")
    found = [
        (turn, f"{folder.name}/{name.name}", int(scene.stem.removeprefix("scene")))
        for name in sets
        for turn, scene in enumerate(sorted(name.glob("scene*.yaml"))[:limit])
    ]
    return [(family, number) for _, family, number in sorted(found)]


def in_turn(of_robots: dict[str, list[tuple[str, int]]]) -> list[tuple[str, int]]:
    """Return all problems, each robot's spread evenly over the whole run."""
    placed = [
        ((place + 0.5) / len(keys), order, key)
        for order, keys in enumerate(of_robots.values())
        for place, key in enumerate(keys)
    ]
    return [key for _, _, key in sorted(placed)]


def row_name(family: str, number: int) -> str:
    """Return the name of a problem's row."""
    return f"{family}-{number}"


@cache
def problems(data: Path, name: str) -> dict[str, Instance] | to.TrajoptError:
    """Return the problems of a robot by name, or why its files are refused."""
    folder = data / name / "robot"
    try:
        robot = (
            to.load("panda")
            if name == "panda"
            else to.Robot.from_urdf(folder / f"{name}.urdf", srdf=folder / f"{name}.srdf")
        )
    except to.TrajoptError as error:
        return error
    return {item.name: item for item in find_instances(data / name, robot)}


def prepare(data: Path, robots: Sequence[str]) -> None:
    """Load the robots and plan a problem of each, so that late imports are not measured."""
    for name in robots:
        found = problems(data, name)
        if not isinstance(found, to.TrajoptError):
            ask(data, f"{name}/{min(found).split('/')[0]}", int(min(found).split("/")[1]))


def ask(data: Path, family: str, number: int) -> Row:
    """Plan a problem and return its outcome."""
    robot, set_name = family.split("/")
    row: Row = {"key": row_name(family, number), "family": family, "seed": number}
    wall = time.perf_counter()
    try:
        found = problems(data, robot)
        if isinstance(found, to.TrajoptError):
            raise found
        told = run(found[f"{set_name}/{number}"])
        row |= {"outcome": "verified" if told.verified else "failed", "detail": told.message}
        row["told"] = told.as_dict()
    except to.TrajoptError as error:
        words = str(error).replace(str(data), "DATA")
        row |= {"outcome": "refused", "detail": f"{type(error).__name__}: {words}"}
    except Exception as error:  # whatever it is, it costs this problem only, and its row counts as a crash
        last = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{Path(last.filename).name}:{last.lineno}"
        row |= {"outcome": "crash", "detail": f"{type(error).__name__}: {error} ({where})"}
    return row | {"wall": round(time.perf_counter() - wall, 3)}


if __name__ == "__main__":
    main()
