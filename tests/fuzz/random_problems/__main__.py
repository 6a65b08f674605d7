"""Random problems: `python -m tests.fuzz.random_problems --out out/fuzz --count 5000 --workers 2`.

A row for each problem is appended to `rows.jsonl`; what has a row is not asked again. A problem that
runs over its time is ended with its process and counted as a hang. Exit status 1 if there is a false success,
a false proof, a hang or a crash.
"""

import argparse
import sys
from pathlib import Path

from benchmarks.rows import Rows
from benchmarks.workers import run
from tests.fuzz.random_problems.registry import FAMILIES, keys
from tests.fuzz.random_problems.summary import summary
from tests.fuzz.random_problems.trial import FALSE, trial


def main(arguments: list[str] | None = None) -> int:
    """Run what has no row yet, print the table, and return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz.random_problems", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/fuzz"), help="folder of rows and summary")
    parser.add_argument("--count", type=int, default=5000, help="problems, over all families")
    parser.add_argument("--start", type=int, default=0, help="first seed of each family")
    parser.add_argument("--families", nargs="+", choices=FAMILIES, default=[], help="these only")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=120.0, help="wall-clock time of one problem at most")
    asked = parser.parse_args(arguments)
    rows = Rows(asked.out / "rows.jsonl")
    wanted = list(keys(asked.count, start=asked.start, families=asked.families))
    missing = [key for key in wanted if f"{key[0]}-{key[1]}" not in rows.done]
    print(f"{len(wanted)} problems, {len(wanted) - len(missing)} of them done before", flush=True)
    run(missing, ask=trial, workers=asked.workers, seconds=asked.seconds, keep=rows.append)
    chosen = [rows.done[f"{family}-{seed}"] for family, seed in wanted]
    text = summary(chosen)
    (asked.out / "summary.md").write_text(text)
    print(text)
    return int(any(row["outcome"] in FALSE for row in chosen))


if __name__ == "__main__":
    sys.exit(main())
