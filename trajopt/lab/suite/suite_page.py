"""Outcomes of the suite as an HTML page, as text, and as data."""

from collections.abc import Mapping, Sequence
from html import escape

from trajopt.lab.suite.html import document, image, table, used_share, words
from trajopt.lab.suite.outcome import RunOutcome
from trajopt.planning.status import Status
from trajopt.values.printed import aligned
from trajopt.verify import Check, CheckKind

STYLE = """
summary { display: grid; grid-template-columns: 1.2rem 15rem 5.5rem 16rem 1fr 5rem; gap: .1rem .8rem;
  align-items: baseline; list-style: none; }
summary:has(img) { grid-template-columns: 7rem 1.2rem 13rem 4.5rem 11rem 1fr 4.5rem; align-items: center; }
details[open] summary:has(img) { grid-template-columns: 20rem 1.2rem 12rem 4.5rem 8rem 1fr 4.5rem; }
summary img { width: 100%; height: auto; border-radius: 4px; }
@media (max-width: 62rem) {
  summary, summary:has(img), details[open] summary:has(img) { grid-template-columns: 1.2rem 1fr 6rem; }
  summary img { grid-column: 1 / 4; max-width: 20rem; }
  summary .faint, summary .seconds, summary .told { grid-column: 2 / 4; text-align: left; }
}
summary::-webkit-details-marker { display: none; }
summary b, td { overflow-wrap: anywhere; }
.seconds { text-align: right; font-variant-numeric: tabular-nums; }
.wide { margin-bottom: .8rem; }
.bar { width: 6rem; height: .55rem; background: var(--soft); border-radius: 3px; margin-top: .35rem; }
.bar i { display: block; height: 100%; border-radius: 3px; background: var(--good); }
.bar i.bad { background: var(--bad); }
"""

COLUMNS = ("constraint", "where", "worst", "bound", "unit", "used", "at [s]", "evidence")
NUMBERS = ("worst", "bound", "at [s]")


def page(
    outcomes: Sequence[RunOutcome], pictures: Mapping[tuple[str, int], bytes] | None = None, remark: str = ""
) -> str:
    """Return the page: one line per problem, which expands to its constraints; failures are expanded.

    Args:
        pictures: A thumbnail of each, by the problem's name and the number of its instance.
        remark: A sentence for the head of the page.
    """
    drawn = pictures or {}
    lines = [_one(outcome, drawn.get((outcome.problem, outcome.draw))) for outcome in outcomes]
    return document(
        "trajopt suite",
        STYLE,
        f"<p>{escape(summary(outcomes))}. Every value is a judge's own, measured on the timed motion. Open a "
        f"line to see each constraint where it is tightest. {escape(remark)}</p>{''.join(lines)}",
    )


def _one(outcome: RunOutcome, picture: bytes | None) -> str:
    good = outcome.good
    told = words(outcome.status)
    if outcome.status is not outcome.expected:
        told += f", expected {words(outcome.expected)}"
    return (
        f"<details{'' if good else ' open'}><summary>{image(picture)}"
        f'<span class="{"good" if good else "bad"}">'
        f"{'✓' if good else '✗'}</span><b>{escape(outcome.problem)}</b><span>{outcome.instance}</span>"
        f'<span class="told">{escape(told)}</span><span class="faint">{_motion(outcome)}</span>'
        f'<span class="seconds">{1000 * outcome.cpu_seconds:.0f} ms</span></summary>{_inside(outcome)}'
        "</details>"
    )


def _motion(outcome: RunOutcome) -> str:
    if outcome.duration is None or outcome.status is not Status.SOLVED:
        return ""
    near = [
        f"{1000 * item.value:.1f} mm clear" + (f" ({1000 * item.bound:g} mm required)" if item.bound else "")
        for item in outcome.constraints
        if item.kind is CheckKind.CLEARANCE and item.value is not None
    ]
    return ", ".join([f"motion of {outcome.duration:.2f} s", *near])


def _inside(outcome: RunOutcome) -> str:
    if not outcome.constraints:
        return f"<p>{escape(outcome.message)}</p>"
    return table(COLUMNS, [_row(item) for item in outcome.constraints], numbers=NUMBERS)


def _row(item: Check) -> tuple[str, ...]:
    name = escape(item.name)
    return (
        name if item.holds else f'<b class="bad">{name}</b>',
        escape(item.subject),
        number(item.value),
        number(item.bound),
        escape(item.unit),
        used_share(item),
        "" if item.time is None else f"{item.time:.3f}",
        item.evidence.value,
    )


HEAD = ("", "problem", "instance", "constraint", "where", "worst", "bound", "unit", "at [s]", "evidence")
WIDEST = 48
"""Longer names of constraints are cut."""
_COLUMNS = {
    **{name: name for name in ("name", "subject", "bound", "unit", "time", "evidence", "holds")},
    "worst": "value",
}
"""Key of a constraint as data -> the attribute of a check."""


def text_table(outcomes: Sequence[RunOutcome]) -> list[str]:
    rows: list[tuple[str, ...]] = [HEAD]
    for outcome in outcomes:
        lead = ("ok" if outcome.good else "FAIL", outcome.problem, outcome.instance)
        told = [cells(item) for item in outcome.constraints] or [(reason(outcome), "", "", "", "", "", "")]
        for count, row in enumerate(told):
            rows.append((*(lead if count == 0 else ("", "", "")), *row))
    return aligned(rows, right=frozenset((5, 6, 8)))


def cells(item: Check) -> tuple[str, str, str, str, str, str, str]:
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


def reason(outcome: RunOutcome) -> str:
    told = f"refused: {outcome.status.name}"
    return told if outcome.good else f"{told}, expected {ending(outcome.expected)}"


def ending(status: Status) -> str:
    return "solved" if status is Status.SOLVED else status.name


def row(outcome: RunOutcome) -> dict[str, object]:
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


def summary(outcomes: Sequence[RunOutcome]) -> str:
    """Sum up in a line."""
    good = sum(outcome.good for outcome in outcomes)
    used = sum(outcome.cpu_seconds for outcome in outcomes)
    return f"{good} of {len(outcomes)} as expected; planning took {used:.1f} s of CPU"
