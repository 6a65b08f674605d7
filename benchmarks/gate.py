"""Exact counts of a few problems against a committed baseline: work that grows is seen before time is.

python -m benchmarks.gate [--write]

Counts, never times. They are the same on every machine but for the last bits of floating point, which may
turn one decision of an optimiser: so the sum over all problems may exceed the baseline by a tenth.
"""

import argparse
import json
import tempfile
from pathlib import Path

from trajopt_problems.cup_past_pillar import problem as cup_past_pillar

import trajopt as to
from benchmarks.measuring import COUNTS
from benchmarks.problems import arms, over_waves, past_pillar

BASELINE = Path(__file__).with_name("baseline.json")
ROOM = 1.1
"""A count may grow by this factor before the gate closes."""


def counts() -> dict[str, dict[str, int]]:
    """Plan every problem of the gate and return its exact counts."""
    panda = to.load("panda")
    with tempfile.TemporaryDirectory() as folder:
        problems = {
            "past pillar": past_pillar(panda),
            "past pillar, 100 knots": past_pillar(panda, knots=100),
            "past pillar, 300 boxes": past_pillar(panda, boxes=300),
            "over 10,000 waves": over_waves(panda, 10_000),
            "cup past pillar": cup_past_pillar(),
            "one arm": arms(Path(folder), 7),
            "two arms": arms(Path(folder), 14),
        }
        found: dict[str, dict[str, int]] = {}
        for name, problem in problems.items():
            result = to.plan(problem)
            found[name] = {count: int(result.counts.get(count, 0)) for count in COUNTS}
            found[name]["solved"] = int(result.verified)
    return found


def total(found: dict[str, dict[str, int]]) -> dict[str, int]:
    """Return the sum of each count over all problems."""
    return {count: sum(each[count] for each in found.values()) for count in (*COUNTS, "solved")}


def main() -> None:
    """Print the counts; write the baseline on request."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--write", action="store_true", help="make these counts the baseline")
    found = counts()
    print(json.dumps(found, indent=1))
    if parser.parse_args().write:
        BASELINE.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
