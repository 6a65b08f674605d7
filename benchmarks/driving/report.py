"""The table of runs, and the definition of a failure."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.driving.drawing import Part
from benchmarks.page import table

SHORTFALL = 1e-4
"""Accepted shortfall of a distance in a stepped simulation below the proven one [m]."""
HEADS = [
    "", "runs", "reached the goal", "contacts at fault", "contacts at rest", "unproven stops",
    "measured below proven by at most [mm]", "replanned on the way", "stopped", "median duration [s]",
    "p99 duration [s]",
]  # fmt: skip
Row = Mapping[str, Any]


def failed(row: Row) -> bool:
    """Return whether a run broke a promise within the stated errors, or ended by an exception."""
    if "error" in row:
        return True
    if "not_drawn" in row or row["part"] == Part.BEYOND.value:
        return False
    proven = row["proven"]
    below = proven is not None and row["measured"] < proven - SHORTFALL
    return bool(row["contacts_at_fault"] or row["unproven_stops"] or row["off_track"] or below)


def _line(name: str, rows: Sequence[Row]) -> list[str]:
    below = [
        1e3 * (row["proven"] - row["measured"])
        for row in rows
        if row["proven"] is not None and np.isfinite(row["measured"])
    ]
    took = [row["duration"] for row in rows]
    return [
        name,
        str(len(rows)),
        str(sum(row["reached"] for row in rows)),
        str(sum(bool(row["contacts_at_fault"]) for row in rows)),
        str(sum(bool(row["contacts"]) and not row["contacts_at_fault"] for row in rows)),
        str(sum(row["unproven_stops"] > 0 for row in rows)),
        f"{max(below):.2f}" if below else "-",
        str(sum(row["replans"] > 0 for row in rows)),
        str(sum(row["stops"] > 0 for row in rows)),
        f"{np.median(took):.2f}",
        f"{np.percentile(took, 99.0):.2f}",
    ]


def page(rows: Iterable[Row], names: Sequence[str]) -> str:
    """Return the section of the page."""
    given = list(rows)
    errors = [row for row in given if "error" in row]
    by_way: dict[str, list[Row]] = {}
    for row in given:
        if "not_drawn" in row or "error" in row:
            continue
        by_way.setdefault(str(row["key"]).split(" ", 3)[3], []).append(row)
    within = [row for row in by_way.get("supervisor", []) if row["part"] != Part.BEYOND.value]
    lines = [_line("all", within)] if within else []
    for part in (Part.APPEARS, Part.LATE, Part.MOVES):
        lines += _lines(f"of these, `{part.value}`", [row for row in within if row["part"] == part.value])
    same = [row for row in within if " ".join(str(row["key"]).split(" ", 3)[:3]) in _prefixes(by_way)]
    others = _lines("supervisor", same) if same else []
    for way, found in by_way.items():
        others += _lines(way, found) if way != "supervisor" else []
    beyond = [row for row in by_way.get("supervisor", []) if row["part"] == Part.BEYOND.value]
    failures = [f"`{row['key']}`" for row in within if failed(row)]
    parts = [
        f"Problems: {', '.join(f'`{name}`' for name in names)}.",
        "",
        f"{len(within)} runs of the supervisor within the stated errors:",
        "",
        table(HEADS, lines),
        "",
        f"Failures (problem, seed): {', '.join(failures) if failures else 'none'}.",
    ]
    if errors:
        parts += ["", f"{len(errors)} runs ended with an exception and are not in the tables:", ""]
        parts += [f"- `{row['key']}`: {row['error']}" for row in errors]
    if others:
        parts += ["", "Other rules, same problems and seeds:", "", table(HEADS, others)]
    if beyond:
        parts += ["", "Beyond the stated errors:", "", table(HEADS, _lines("supervisor", beyond))]
    return "\n".join(parts)


def _prefixes(by_way: Mapping[str, Sequence[Row]]) -> set[str]:
    """Return problem, seed and part of the runs that other rules drove too."""
    return {
        " ".join(str(row["key"]).split(" ", 3)[:3])
        for way, rows in by_way.items()
        if way != "supervisor"
        for row in rows
    }


def _lines(name: str, rows: Sequence[Row]) -> list[list[str]]:
    return [_line(name, rows)] if rows else []
