"""Point clouds: MotionBenchMaker's Panda problems as points, with primitives, and with OMPL.

python -m benchmarks.clouds DATA [--every N] [--ompl N] [--parity N] [--page FILE]

DATA holds panda/<set>/. Of each N-th problem the scene is planned as it is, as 10,000 points drawn on each
object with balls of 2.5 mm, and thinned to one point in each cell of 5 mm with balls that cover. --ompl: each
so many-th also by OMPL's RRT-Connect with Coal on the same thinned balls. --parity: so many random scenes are
judged as a cloud and as single balls. Rows are kept in --out; what has one there is not asked again.
"""

import argparse
from functools import partial
from pathlib import Path

from benchmarks.clouds.asking import PARITY, ask, prepare
from benchmarks.clouds.report import section
from benchmarks.motion_bench_maker import listed
from benchmarks.page import write_section
from benchmarks.rows import Rows
from benchmarks.workers import run


def main() -> None:
    """Plan the problems without a row, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--every", type=int, default=1, help="each so many-th problem")
    parser.add_argument(
        "--ompl", type=int, default=10, help="each so many-th of these by OMPL too; 0 for none"
    )
    parser.add_argument("--parity", type=int, default=200, help="random scenes judged twice")
    parser.add_argument("--out", type=Path, default=Path("out/clouds"), help="folder of the rows")
    parser.add_argument("--seconds", type=float, default=300.0, help="wall-clock time of a problem at most")
    parser.add_argument("--page", type=Path, help="Markdown file with the section's markers")
    given = parser.parse_args()
    rows = Rows(given.out / "rows.jsonl")
    keys = listed(given.data / "panda", None)[:: given.every]
    drawn = {key for key in keys[:: given.ompl]} if given.ompl else set[tuple[str, int]]()
    asked = [(f"{family}{' ompl' * ((family, number) in drawn)}", number) for family, number in keys]
    asked += [(PARITY, number) for number in range(given.parity)]
    missing = [key for key in asked if f"{key[0]}-{key[1]}" not in rows.done]
    print(f"{len(asked)} problems, {len(asked) - len(missing)} of them done before", flush=True)
    run(
        missing, ask=partial(ask, given.data.resolve()), workers=1, seconds=given.seconds, keep=rows.append,
        prepare=partial(prepare, given.data.resolve()),
    )  # fmt: skip
    text = section([rows.done[f"{family}-{number}"] for family, number in asked])
    print(text)
    if given.page is not None:
        write_section(given.page, "clouds", text)


if __name__ == "__main__":
    main()
