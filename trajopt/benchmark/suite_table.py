"""Entries as a text: one line for each constraint, and a sum at the end."""

from collections.abc import Sequence

from trajopt.benchmark.entry import Entry, outcome
from trajopt.model.printed import aligned
from trajopt.verify import Check

HEAD = ("", "problem", "instance", "constraint", "where", "worst", "bound", "unit", "at [s]", "evidence")
WIDEST = 48
"""Longer names of constraints are cut."""


def table(entries: Sequence[Entry]) -> list[str]:
    """Return aligned lines: every constraint of every entry with its worst value, bound and time."""
    rows: list[tuple[str, ...]] = [HEAD]
    for entry in entries:
        lead = ("ok" if entry.as_expected else "FAIL", entry.problem, entry.instance)
        told = [cells(item) for item in entry.constraints] or [(reason(entry), "", "", "", "", "", "")]
        for count, row in enumerate(told):
            rows.append((*(lead if count == 0 else ("", "", "")), *row))
    return aligned(rows, right=frozenset((5, 6, 8)))


def cells(item: Check) -> tuple[str, str, str, str, str, str, str]:
    """Return a constraint as constraint, where, worst, bound, unit, time and evidence."""
    name = item.name if len(item.name) <= WIDEST else f"{item.name[: WIDEST - 3]}..."
    return (
        name if item.holds else f"BROKEN {name}",
        item.subject,
        number(item.value),
        number(item.bound),
        item.unit,
        "" if item.time is None else f"{item.time:.3f}",
        item.evidence.value,
    )


def reason(entry: Entry) -> str:
    """Say how an entry ended, and how it should have where that differs."""
    told = f"refused: {entry.status.name}"
    return told if entry.as_expected else f"{told}, expected {outcome(entry.expected)}"


def number(value: float | None) -> str:
    """Return a value with four digits; nothing where there is none."""
    return "" if value is None else f"{value:.4g}"


def summary(entries: Sequence[Entry]) -> str:
    """Sum up in a line."""
    good = sum(entry.as_expected for entry in entries)
    used = sum(entry.cpu_seconds for entry in entries)
    return f"{good} of {len(entries)} as expected; planning took {used:.1f} s of CPU"
