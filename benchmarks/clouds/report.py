"""The table of the clouds."""

from collections.abc import Sequence
from typing import Any, cast

import numpy as np

from benchmarks.clouds.sampling import CELL, COVERING, EACH, RADIUS, RAW, THIN
from benchmarks.page import table
from benchmarks.workers import Row

OUTSIDE = ("GOAL_OUT_OF_LIMITS", "START_OUT_OF_LIMITS")
"""How problems end that no scene makes easier."""


def section(rows: Sequence[Row]) -> str:
    """Return tables and sentences for the page."""
    known = [cast("dict[str, Any]", row) for row in rows if "primitives" in row]
    asked = [row for row in known if row["primitives"]["status"] not in OUTSIDE]
    lost = [row for row in rows if row["outcome"] in ("crash", "hang")]
    names = {"primitives": "primitives", RAW: f"{EACH:,} points an object, balls of {1e3 * RADIUS:g} mm"}
    names[THIN] = f"one point in {1e3 * CELL:g} mm cells, balls of {1e3 * COVERING:.1f} mm"
    plain = _median(row["primitives"] for row in asked if row["primitives"]["judged"])
    lines = list[list[str]]()
    for key, words in names.items():
        free = [row[key] for row in asked if row[key].get("free", True)]
        solved = [each for each in free if each["judged"]]
        cpu = [each["cpu"] for each in solved]
        points = np.median([each.get("points", 0) for each in free]) if free else 0
        lines.append([
            words, f"{points:,.0f}" if points else "-", f"{len(solved)} of {len(free)}",
            f"{1e3 * np.median(cpu):.0f} / {1e3 * np.percentile(cpu, 90):.0f} / {1e3 * max(cpu):.0f} ms",
            f"{np.median(cpu) / plain:.2f}",
        ])  # fmt: skip
    head = [
        "scene",
        "points (median)",
        "planned, of free problems",
        "CPU: median / p90 / worst",
        "ratio to primitives",
    ]
    texts = [
        f"{len(asked)} Panda problems of MotionBenchMaker. Free: start and goal are clear of the same balls "
        "by Pinocchio and Coal. CPU: `plan()` with all trees of the scene. Planned: proven by a "
        "separate judge."
        + f" {len(known) - len(asked)} more end outside the joint limits." * (len(known) > len(asked))
        + f" {len(lost)} lost (a crash, or out of time)." * bool(lost),
        table(head, lines),
        *_beside_ompl(asked),
        *_parity([cast("dict[str, Any]", row) for row in rows if "balls" in row]),
    ]
    return "\n\n".join(texts)


def _beside_ompl(asked: Sequence[dict[str, Any]]) -> list[str]:
    both = [row for row in asked if "ompl" in row]
    if not both:
        return []
    theirs, ours = [row["ompl"] for row in both], [row[THIN] for row in both]
    lines = [
        ["trajopt", f"{sum(each['judged'] for each in ours)} of {len(both)}", _cpu(ours)],
        [
            "OMPL 2.0.1, RRT-Connect and simplifier",
            f"{sum(each['judged'] for each in theirs)} of {len(both)}",
            _cpu(theirs),
        ],
    ]
    lost = [each["cpu"] for each in theirs if not each["found"]]
    words = f" It found no path in 30 s of wall time on {len(lost)}" * bool(lost)
    words += f" ({min(lost):.0f} to {max(lost):.0f} s of CPU)." if lost else ""
    return [
        f"OMPL with Coal on the same balls, on {len(both)} of the thinned scenes, checked every 0.02 "
        "rad. Its polyline is judged for clearance only and is not timed." + words,
        table(["", "proven clear", "CPU: median / p90"], lines),
    ]


def _parity(rows: Sequence[dict[str, Any]]) -> list[str]:
    if not rows:
        return []
    same = sum(row["cloud"]["holds"] == row["balls"]["holds"] for row in rows)
    passed = sum(row["balls"]["clear"] for row in rows)
    apart = max(abs(row["cloud"]["slack"] - row["balls"]["slack"]) for row in rows if row["balls"]["clear"])
    return [
        f"A motion judged with a cloud and with its balls as `Sphere` parts: {same} of {len(rows)} verdicts "
        f"agree ({passed} clear); clearances differ by up to {1e3 * apart:.2f} mm at a resolution of 1 mm."
    ]


def _cpu(rows: Sequence[dict[str, Any]]) -> str:
    cpu = [each["cpu"] for each in rows if each["judged"]]
    return f"{1e3 * np.median(cpu):.0f} / {1e3 * np.percentile(cpu, 90):.0f} ms" if cpu else "-"


def _median(rows: Any) -> float:
    return float(np.median([each["cpu"] for each in rows]))
