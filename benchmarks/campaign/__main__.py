"""The tables of campaigns: measurements and faults.

python -m benchmarks.campaign [--page FILE] [--counts 1000,10000,100000] [--tables]

Runs `benchmarks.campaign.scale` and `benchmarks.campaign.faults`, whose figures are kept in
benchmarks/results, and writes the section of the page from all that is there; with --tables it runs nothing.
"""

import argparse
import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.page import table, write_section

RESULTS = Path("benchmarks/results")
SCALE, FAULTS = RESULTS / "campaign_scale.jsonl", RESULTS / "campaign_faults.json"
MILLION = 1_000_000


def main() -> None:
    """Measure, and write the section."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--page", type=Path)
    parser.add_argument("--counts", default="1000,10000,100000")
    parser.add_argument("--tables", action="store_true")
    given = parser.parse_args()
    if not given.tables:
        for name, *more in (
            ("scale", "--counts", given.counts),
            ("scale", "--counts", "1000", "--robot", "panda"),
            ("faults",),
        ):
            subprocess.run([sys.executable, "-m", f"benchmarks.campaign.{name}", *more], check=True)
    text = "\n\n".join((scale_table(), model_table(), faults_table()))
    print(text)
    if given.page is not None:
        write_section(given.page, "campaign", text)


def runs() -> list[dict[str, Any]]:
    """Return the latest run of each engine, robot and size."""
    lines = SCALE.read_text().splitlines() if SCALE.exists() else []
    found = {(each["engine"], each["robot"], each["rows"]): each for each in map(json.loads, lines)}
    return [found[key] for key in sorted(found)]


def scale_table() -> str:
    """Return the cost of each run."""
    head = (
        *("engine", "robot", "rows", "verified", "wall s", "planning CPU s", "other CPU s", "of it start s"),
        *("idle s", "waiting s", "reached", "without start", "driver MB", "worker MB", "KB a row"),
    )
    rows = [
        (
            *(run["engine"], run["robot"], f"{run['rows']:,}", f"{run['verified']:,}"),
            *(f"{run['seconds']:.0f}", f"{run['planning']:.0f}", f"{run['others']:.1f}"),
            f"{run['start']:.1f}" if "start" in run else "",
            *(f"{run['idle']:.1f}", f"{run['waited']:.1f}", f"{reached(run, 0.0):.0%}"),
            f"{reached(run, run['start']):.0%}" if "start" in run else "",
            " / ".join(f"{driver:.0f}" for driver, _ in run["megabytes"]),
            " / ".join(f"{worker:.0f}" for _, worker in run["megabytes"]),
            f"{run['bytes'] / run['rows'] / 1e3:.1f}",
        )
        for run in runs()
    ]
    return table(head, rows)


def reached(run: Mapping[str, Any], start: float) -> float:
    """Return the share of (cores x single-core rate) that a run had, as `benchmarks.campaign.scale` says.

    Args:
        run: What was measured.
        start: Process time that does not count [s].
    """
    lost = max(run["idle"], run["waited"])
    return run["planning"] / (run["planning"] + run["others"] - start + lost)


def model_table() -> str:
    """Return what a line through the two smaller runs says of the largest, and of a million.

    The line is of what a campaign costs beside planning; a row's planning is that of the largest run.
    """
    head = (
        *("engine", "planning, ms a row", "other, ms a row", "once, s", "other CPU: model / measured"),
        *("a million: core hours", "GB"),
    )
    rows: list[tuple[str, ...]] = []
    for engine in dict.fromkeys(run["engine"] for run in runs()):
        mine = [run for run in runs() if (run["engine"], run["robot"]) == (engine, "planar2")]
        if len(mine) < 2:
            continue
        last = mine[-1]
        each, planning = last["rows"], last["planning"] / last["rows"]
        slope, once = np.polyfit([run["rows"] for run in mine[:2]], [run["others"] for run in mine[:2]], 1)
        said = f"{once + slope * each:.0f} / {last['others']:.0f} s at {each:,} rows"
        hours = (once + (slope + planning) * MILLION) / 3600.0
        rows.append(
            (
                *(engine, f"{1e3 * planning:.1f}", f"{1e3 * slope:.2f}", f"{once:.1f}"),
                *(
                    said if len(mine) > 2 else "",
                    f"{hours:.1f}",
                    f"{last['bytes'] / each * MILLION / 1e9:.1f}",
                ),
            )
        )
    return table(head, rows)


def faults_table() -> str:
    """Return the outcomes of disturbed campaigns."""
    found: list[dict[str, Any]] = json.loads(FAULTS.read_text()) if FAULTS.exists() else []
    head = (
        "engine",
        "disturbance",
        "rows at that time",
        "rows when it ended",
        "after resuming",
        "unique ids",
        "equal to an undisturbed run",
    )
    rows = [
        (
            *(each["engine"], each["fault"], str(each["before"]), str(each["after"]), str(each["rows"])),
            *(str(each["unique"]), "to the last digit" if each["same"] else "NO"),
        )
        for each in found
    ]
    return table(head, rows)


if __name__ == "__main__":
    main()
