"""Plans in threads and in processes: plans a second, in turn, in one run.

python -m benchmarks.threads DATA [--workers 2] [--rounds 6] [--limit K] [--json FILE] [--page FILE]

Processes are as good as it gets: nothing is shared but the machine. They are started, and have planned every
problem, before anything is timed. Time is wall time, for that is what side by side is about: ratios within
one run are what counts. Every round, one worker, the threads and the processes take the same problems.
"""

import argparse
import json
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from multiprocessing import get_context
from pathlib import Path

import numpy as np

import trajopt as to
from benchmarks.page import table, write_section
from trajopt.lab.suite.instance import find_instances

ROUNDS = 6
PROBLEMS = 5


@cache
def problems(folder: Path, limit: int) -> tuple[to.Problem, ...]:
    """Return the Panda's problems, read once in each process."""
    robot = to.load("panda")
    return tuple(item.make() for item in find_instances(folder, robot, limit=limit))


def every(folder: Path, limit: int, first: int, step: int) -> int:
    """Plan every n-th problem of a folder in sequence; return the number of solved ones."""
    return sum(to.plan(problem).verified for problem in problems(folder, limit)[first::step])


def seconds(work: Callable[[], int]) -> tuple[float, int]:
    """Return the wall time of a function, and its result."""
    begin = time.perf_counter()
    solved = work()
    return time.perf_counter() - begin, solved


def measured(folder: Path, workers: int, rounds: int, limit: int) -> tuple[dict[str, list[float]], int]:
    """Return the plans a second of each way in each round, and how many problems there are."""
    asked = problems(folder, limit)
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool:

        def in_processes() -> int:
            running = [pool.submit(every, folder, limit, first, workers) for first in range(workers)]
            return sum(each.result() for each in running)

        def in_threads(count: int) -> int:
            return sum(result.verified for result in to.plan_many(asked, workers=count, bar=False))

        ways: dict[str, Callable[[], int]] = {
            "one thread": lambda: in_threads(1),
            f"{workers} threads": lambda: in_threads(workers),
            f"{workers} processes": in_processes,
        }
        solved = {name: {way() for _ in range(2)} for name, way in ways.items()}
        rates: dict[str, list[float]] = {name: [] for name in ways}
        for turn in range(rounds):
            names = list(ways)
            for name in names[turn % 3 :] + names[: turn % 3]:
                took, found = seconds(ways[name])
                solved[name].add(found)
                rates[name].append(len(asked) / took)
    if len({found for each in solved.values() for found in each}) != 1:
        raise SystemExit(f"not the same problems were solved: {solved}")
    return rates, len(asked)


def rows(rates: dict[str, list[float]]) -> list[list[str]]:
    """Return the rows of the table."""
    *_, best = rates
    return [
        [
            name,
            f"{np.median(rate):.1f}",
            f"{np.median(np.divide(rate, rates['one thread'])):.2f}",
            f"{np.median(np.divide(rate, rates[best])):.2f}",
        ]
        for name, rate in rates.items()
    ]


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and write the section."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    parser.add_argument("--limit", type=int, default=PROBLEMS, help="problems of each set at most")
    parser.add_argument("--json", type=Path, default=Path("benchmarks/results/threads.json"))
    parser.add_argument("--page", type=Path, help="Markdown file with the section's markers")
    given = parser.parse_args(arguments)
    rates, count = measured(given.data.resolve() / "panda", given.workers, given.rounds, given.limit)
    text = table(["", "plans a second", "relative to one thread", "relative to processes"], rows(rates))
    text += f"\n\n{count} problems in each of {given.rounds} rounds; medians."
    print(text)
    given.json.parent.mkdir(parents=True, exist_ok=True)
    given.json.write_text(json.dumps(rates, indent=1) + "\n")
    if given.page is not None:
        write_section(given.page, "threads", text)


if __name__ == "__main__":
    main()
