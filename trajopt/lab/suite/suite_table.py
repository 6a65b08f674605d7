"""Outcomes of the suite as text, one line for each constraint and a total at the end; and as data."""

from collections.abc import Sequence

from trajopt.lab.suite.outcome import Outcome
from trajopt.planning.status import Status
from trajopt.values.printed import aligned
from trajopt.verify import Check

HEAD = ("", "problem", "instance", "constraint", "where", "worst", "bound", "unit", "at [s]", "evidence")
WIDEST = 48
"""Longer names of constraints are cut."""
_COLUMNS = {
    **{name: name for name in ("name", "subject", "bound", "unit", "time", "evidence", "holds")},
    "worst": "value",
}
"""Key of a constraint as data -> the attribute of a check."""


def table(outcomes: Sequence[Outcome]) -> list[str]:
    """Return aligned lines: every constraint of every motion with its worst value, bound and time."""
    rows: list[tuple[str, ...]] = [HEAD]
    for outcome in outcomes:
        lead = ("ok" if outcome.good else "FAIL", outcome.problem, outcome.instance)
        told = [cells(item) for item in outcome.constraints] or [(reason(outcome), "", "", "", "", "", "")]
        for count, row in enumerate(told):
            rows.append((*(lead if count == 0 else ("", "", "")), *row))
    return aligned(rows, right=frozenset((5, 6, 8)))


def cells(item: Check) -> tuple[str, str, str, str, str, str, str]:
    """Return a constraint as constraint, place, worst value, bound, unit, time and evidence."""
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


def reason(outcome: Outcome) -> str:
    """Return the status, and the expected one if it differs."""
    told = f"refused: {outcome.status.name}"
    return told if outcome.good else f"{told}, expected {ending(outcome.expected)}"


def ending(status: Status) -> str:
    """Return "solved", or the name of the reason of refusal."""
    return "solved" if status is Status.SOLVED else status.name


def row(outcome: Outcome) -> dict[str, object]:
    """Return plain data that JSON can hold; numbers that are not finite become None."""
    return {
        "problem": outcome.problem,
        "instance": outcome.instance,
        "expected": ending(outcome.expected),
        "outcome": ending(outcome.status),
        "as_expected": outcome.good,
        "message": outcome.message,
        "constraints": [
            {key: plain[name] for key, name in _COLUMNS.items()}
            for plain in (check.as_dict() for check in outcome.constraints)
        ],
        "setup_seconds": outcome.setup_seconds,
        "cpu_seconds": outcome.cpu_seconds,
        "duration": outcome.duration,
    }


def number(value: float | None) -> str:
    """Return a value with four digits; empty for None."""
    return "" if value is None else f"{value:.4g}"


def summary(outcomes: Sequence[Outcome]) -> str:
    """Sum up in a line."""
    good = sum(outcome.good for outcome in outcomes)
    used = sum(outcome.cpu_seconds for outcome in outcomes)
    return f"{good} of {len(outcomes)} as expected; planning took {used:.1f} s of CPU"
