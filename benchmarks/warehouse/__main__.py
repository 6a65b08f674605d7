"""Kills among a thousand writes of two processes, and the cost of keeping and finding.

python -m benchmarks.warehouse [--writes N] [--kills N] [--entries N] [--page FILE]
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import trajopt as to
from benchmarks.page import table, write_section
from benchmarks.warehouse.killing import run
from benchmarks.warehouse.writer import state
from trajopt.problem.problem import named_problem
from trajopt.server.warehouse import Warehouse


def main() -> None:
    """Measure, and write the section of the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--writes", type=int, default=1000, help="that are acknowledged, of both processes")
    parser.add_argument("--kills", type=int, default=10, help="of both processes, while they write")
    parser.add_argument("--entries", type=int, default=1000, help="of the warehouse that is found through")
    parser.add_argument("--page", type=Path, help="Markdown file with the section's markers")
    given = parser.parse_args()
    with TemporaryDirectory() as folder:
        found = run(Path(folder) / "killed", writes=given.writes, kills=given.kills, seed=0)
        rows = [
            ("acknowledged writes of two processes", str(found.acknowledged)),
            ("`kill -9`", str(found.kills)),
            ("acknowledged writes lost", str(found.lost)),
            ("incomplete entries", str(found.half)),
            ("complete entries, killed before acknowledgement", str(found.beyond)),
            *costs(Path(folder) / "costs", given.entries),
        ]
    text = table(["", ""], [list(row) for row in rows])
    print(text)
    if given.page is not None:
        write_section(given.page, "warehouse", text)


def costs(path: Path, entries: int) -> list[tuple[str, str]]:
    """Return the median CPU time of keeping, finding and reading."""
    result = to.plan(named_problem("bookshelf_panda"))
    with Warehouse(path) as kept:
        kept.add("shelf", result)
        kept.close()  # what is in the log goes to the file
        first = path.stat().st_size
        keeping = timed(lambda: kept.add("shelf", result), 20)
        kept.close()
        more = (path.stat().st_size - first) / 20
        for number in range(entries):
            kept.add(f"state {number}", state("arm", number))
        finding = timed(lambda: kept.find(text="state 77"), 20)
        reading = timed(lambda: kept.plan("shelf"), 20)
    return [
        ("keep a plan of a Panda, meshes already stored", f"{keeping:.0f} ms"),
        ("the file: the first plan, with the meshes", f"{first / 2**20:.1f} MB"),
        ("each further plan", f"{more / 2**10:.0f} KB"),
        ("read a plan with robot and scene", f"{reading:.0f} ms"),
        (f"find a word among {entries} entries", f"{finding:.1f} ms"),
    ]


def timed(call: Callable[[], object], count: int) -> float:
    """Return the median CPU time of a call [ms]."""
    times = list[float]()
    for _ in range(count):
        begin = time.process_time()
        call()
        times.append(time.process_time() - begin)
    return 1e3 * float(np.median(times))


if __name__ == "__main__":
    main()
