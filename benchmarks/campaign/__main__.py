"""The tables of campaigns, of what was measured and of what was broken.

python -m benchmarks.campaign [--page FILE] [--counts 1000,10000,100000] [--tables]

Runs `benchmarks.campaign.scale` and `benchmarks.campaign.faults`, whose figures are kept in
benchmarks/results, and writes the section of the page from all that is there; with --tables it runs nothing.
"""

import argparse
import json
import subprocess
import sys
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
        for words in (("scale", "--counts", given.counts), ("faults",)):
            name, *more = words
            subprocess.run([sys.executable, "-m", f"benchmarks.campaign.{name}", *more], check=True)
    text = "\n\n".join((scale_table(), model_table(), faults_table()))
    print(text)
    if given.page is not None:
        write_section(given.page, "campaign", text)


def runs() -> list[dict[str, Any]]:
    """Return the latest run of each engine and size."""
    lines = SCALE.read_text().splitlines() if SCALE.exists() else []
    found = {(each["engine"], each["rows"]): each for each in map(json.loads, lines)}
    return [found[key] for key in sorted(found)]


def scale_table() -> str:
    """Return what each run took."""
    head = (
        *("engine", "rows", "verified", "wall s", "load", "planning CPU s", "other CPU s", "waiting s"),
        *("planning of CPU", "planning of all", "driver MB", "worker MB", "KB a row"),
    )
    rows = [
        (
            *(run["engine"], f"{run['rows']:,}", f"{run['verified']:,}", f"{run['seconds']:.0f}"),
            *(f"{run['load']:.0f}", f"{run['planning']:.0f}", f"{run['others']:.1f}"),
            f"{run['waited']:.1f}",
            f"{run['planning'] / (run['planning'] + run['others']):.0%}",
            f"{run['planning'] / (run['planning'] + run['others'] + run['waited']):.0%}",
            " / ".join(f"{driver:.0f}" for driver, _ in run["megabytes"]),
            " / ".join(f"{worker:.0f}" for _, worker in run["megabytes"]),
            f"{run['bytes'] / run['rows'] / 1e3:.1f}",
        )
        for run in runs()
    ]
    return table(head, rows)


def model_table() -> str:
    """Return what a line through the smaller runs says of the larger, and of a million."""
    head = (
        "engine",
        "CPU s a row",
        "once, s",
        "largest run: model / measured",
        "a million: core hours",
        "GB",
    )
    rows: list[tuple[str, ...]] = []
    for engine in dict.fromkeys(run["engine"] for run in runs()):
        mine = [run for run in runs() if run["engine"] == engine]
        if len(mine) < 2:
            continue
        used = [run["planning"] + run["others"] for run in mine]
        fitted = mine[:2]
        slope, once = np.polyfit([run["rows"] for run in fitted], used[:2], 1)
        largest = mine[-1]
        said = f"{once + slope * largest['rows']:.0f} / {used[-1]:.0f} s" if len(mine) > 2 else "not run"
        hours, size = (once + slope * MILLION) / 3600.0, largest["bytes"] / largest["rows"] * MILLION / 1e9
        rows.append((engine, f"{slope:.4f}", f"{once:.1f}", said, f"{hours:.1f}", f"{size:.1f}"))
    return table(head, rows)


def faults_table() -> str:
    """Return what became of disturbed campaigns."""
    found: list[dict[str, Any]] = json.loads(FAULTS.read_text()) if FAULTS.exists() else []
    head = (
        "engine",
        "in its midst",
        "rows then",
        "rows at its end",
        "after resuming",
        "unique ids",
        "as undisturbed",
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
