"""Entries as one HTML page that needs nothing beside itself."""

from collections.abc import Sequence
from html import escape

from trajopt.benchmark.entry import Entry, outcome
from trajopt.benchmark.suite_table import number, summary
from trajopt.planning.result import Status
from trajopt.verify import Check, CheckKind

STYLE = """
:root { color-scheme: light dark; --line: #8884; --good: #1a7f37; --bad: #cf222e; --soft: #8882; }
body { font: 15px/1.45 system-ui, sans-serif; max-width: 76rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; margin-bottom: .2rem; }
details { border: 1px solid var(--line); border-radius: 6px; margin: .4rem 0; }
summary { cursor: pointer; display: grid; grid-template-columns: 1.2rem 15rem 5.5rem 16rem 1fr 5rem;
  gap: .1rem .8rem; padding: .45rem .8rem; align-items: baseline; list-style: none; }
@media (max-width: 62rem) {
  summary { grid-template-columns: 1.2rem 1fr 6rem; }
  summary .faint, summary .seconds, summary .told { grid-column: 2 / 4; text-align: left; }
  table { display: block; overflow-x: auto; }
}
summary::-webkit-details-marker { display: none; }
summary b { overflow-wrap: anywhere; }
.seconds { text-align: right; font-variant-numeric: tabular-nums; }
.good { color: var(--good); } .bad { color: var(--bad); } .faint { opacity: .7; }
table { border-collapse: collapse; width: calc(100% - 1.6rem); margin: 0 .8rem .8rem; font-size: .9rem; }
th, td { text-align: left; padding: .2rem .6rem .2rem 0; border-top: 1px solid var(--line);
  vertical-align: top; overflow-wrap: anywhere; }
th.n, td.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
.bar { width: 6rem; height: .55rem; background: var(--soft); border-radius: 3px; margin-top: .35rem; }
.bar i { display: block; height: 100%; border-radius: 3px; background: var(--good); }
.bar i.bad { background: var(--bad); }
p.message { margin: 0 .8rem .8rem; }
"""

COLUMNS = ("constraint", "where", "worst", "bound", "unit", "used", "at [s]", "evidence")
NUMBERS = {"worst", "bound", "at [s]"}


def page(entries: Sequence[Entry]) -> str:
    """Return the page: one line an entry, which opens to its constraints; failures stand open."""
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width"><title>trajopt suite</title>'
        f"<style>{STYLE}</style></head><body><h1>trajopt suite</h1><p>{escape(summary(entries))}. "
        "Every value is a judge's own, measured on the timed motion. Open a line to see each constraint "
        "where it is tightest.</p>" + "".join(map(_entry, entries)) + "</body></html>\n"
    )


def _entry(entry: Entry) -> str:
    good = entry.as_expected
    told = _words(entry.status)
    if entry.status is not entry.expected:
        told += f", expected {_words(entry.expected)}"
    return (
        f'<details{"" if good else " open"}><summary><span class="{"good" if good else "bad"}">'
        f"{'✓' if good else '✗'}</span><b>{escape(entry.problem)}</b><span>{entry.instance}</span>"
        f'<span class="told">{escape(told)}</span><span class="faint">{_motion(entry)}</span>'
        f'<span class="seconds">{1000 * entry.cpu_seconds:.0f} ms</span></summary>{_inside(entry)}</details>'
    )


def _words(status: Status) -> str:
    """Return an outcome as a reader says it."""
    return outcome(status).replace("_", " ").lower()


def _motion(entry: Entry) -> str:
    """Say how long a motion takes and how near it comes to anything; nothing where there is none."""
    if entry.duration is None:
        return ""
    near = [
        f"{1000 * item.value:.1f} mm clear" + (f" ({1000 * item.bound:g} mm required)" if item.bound else "")
        for item in entry.constraints
        if item.kind is CheckKind.CLEARANCE and item.value is not None
    ]
    return ", ".join([f"motion of {entry.duration:.2f} s", *near])


def _inside(entry: Entry) -> str:
    if not entry.constraints:
        return f'<p class="message">{escape(entry.message)}</p>'
    head = "".join(f"<th{' class=n' if name in NUMBERS else ''}>{name}</th>" for name in COLUMNS)
    return f"<table><tr>{head}</tr>{''.join(map(_row, entry.constraints))}</table>"


def _row(item: Check) -> str:
    time = "" if item.time is None else f"{item.time:.3f}"
    name = escape(item.name) if item.holds else f'<b class="bad">{escape(item.name)}</b>'
    return (
        f"<tr><td>{name}</td><td>{escape(item.subject)}</td><td class=n>{number(item.value)}</td>"
        f"<td class=n>{number(item.bound)}</td><td>{escape(item.unit)}</td><td>{_bar(item)}</td>"
        f"<td class=n>{time}</td><td>{item.evidence.value}</td></tr>"
    )


def _bar(item: Check) -> str:
    """Draw how much of an upper bound is used up; nothing where there is none."""
    if item.value is None or not item.bound or item.kind is CheckKind.CLEARANCE:
        return ""
    share = min(abs(item.value / item.bound), 1.0)
    kind = "" if item.holds else ' class="bad"'
    return f'<div class="bar" title="{share:.0%}"><i{kind} style="width:{100 * share:.0f}%"></i></div>'
