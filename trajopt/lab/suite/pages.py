"""Outcomes of the suite, and comparisons of methods, as HTML, text and data."""

from collections.abc import Mapping, Sequence
from html import escape
from math import inf

from trajopt.lab.suite.html import document, image, status_words, table, used_share
from trajopt.lab.suite.outcome import MethodSummary, RunOutcome, summaries
from trajopt.planning.status import Status
from trajopt.values.printed import aligned, in_number, in_short
from trajopt.verify import Check, CheckKind

SUITE_STYLE = """
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


def suite_page(
    outcomes: Sequence[RunOutcome], pictures: Mapping[tuple[str, int], bytes] | None = None, remark: str = ""
) -> str:
    """Return the page: one line per problem, which expands to its constraints; failures are expanded.

    Args:
        pictures: A thumbnail of each, by the problem's name and the number of its instance.
    """
    drawn = pictures or {}
    lines = [_one(outcome, drawn.get((outcome.problem, outcome.draw))) for outcome in outcomes]
    return document(
        "trajopt suite",
        SUITE_STYLE,
        f"<p>{escape(summary(outcomes))}. Every value is a judge's own, measured on the timed motion. Open a "
        f"line to see each constraint where it is tightest. {escape(remark)}</p>{''.join(lines)}",
    )


def _one(outcome: RunOutcome, picture: bytes | None) -> str:
    good = outcome.good
    told = status_words(outcome.status.name)
    if outcome.status is not outcome.expected:
        told += f", expected {status_words(outcome.expected.name)}"
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
    name, (*before, at, evidence) = escape(item.name), map(escape, cells(item))
    return name if item.holds else f'<b class="bad">{name}</b>', *before, used_share(item), at, evidence


HEAD = ("", "problem", "instance", "constraint", "where", "worst", "bound", "unit", "at [s]", "evidence")
WIDEST = 48


def text_table(outcomes: Sequence[RunOutcome]) -> list[str]:
    rows: list[tuple[str, ...]] = [HEAD]
    for outcome in outcomes:
        lead = ("ok" if outcome.good else "FAIL", outcome.problem, outcome.instance)
        told = [(_named(item), *cells(item)) for item in outcome.constraints]
        told = told or [(reason(outcome), *[""] * len(HEAD[4:]))]
        for count, row in enumerate(told):
            rows.append((*(lead if count == 0 else ("", "", "")), *row))
    return aligned(rows, right=frozenset((5, 6, 8)))


def _named(item: Check) -> str:
    name = in_short(item.name, WIDEST)
    return name if item.holds else f"BROKEN {name}"


def cells(item: Check) -> tuple[str, ...]:
    return (
        item.subject,
        number(item.value),
        number(item.bound),
        item.unit,
        "" if item.time is None else f"{item.time:.3f}",
        item.evidence.value,
    )


def reason(outcome: RunOutcome) -> str:
    told = f"refused: {outcome.status.name}"
    ending = "solved" if outcome.expected is Status.SOLVED else outcome.expected.name
    return told if outcome.good else f"{told}, expected {ending}"


def number(value: float | None) -> str:
    """Return a value with four digits; empty for None."""
    return "" if value is None else f"{value:.4g}"


def summary(outcomes: Sequence[RunOutcome]) -> str:
    """Sum up in a line."""
    good = sum(outcome.good for outcome in outcomes)
    used = sum(outcome.cpu_seconds for outcome in outcomes)
    return f"{good} of {len(outcomes)} as expected; planning took {used:.1f} s of CPU"


COMPARISON_STYLE = """
.runs td:last-child { white-space: normal; min-width: 12rem; }
.grid td:first-child { width: 40%; } .grid th { font-weight: 600; writing-mode: vertical-rl; text-align: left;
  padding: .4rem .5rem; } .grid th:first-child { writing-mode: horizontal-tb; }
tbody tr:nth-child(even) { background: var(--soft); }
.motions { display: grid; grid-template-columns: repeat(auto-fill, minmax(11rem, 1fr)); gap: .8rem;
  margin: .6rem 0 1rem; } .motions figure { margin: 0; } .motions img { width: 100%; border-radius: 4px; }
summary { display: flex; gap: .8rem; align-items: center; } summary img { width: 6rem; height: auto;
  border-radius: 4px; }
figure { margin: 0 0 1.5rem; } figure img { max-width: 100%; height: auto; background: white;
  border: 1px solid var(--line); border-radius: 6px; } figcaption { opacity: .8; font-size: .9rem; }
"""
TEXTS = {"problem", "solver", "outcome", "broken"}


def comparison_page(
    outcomes: Sequence[RunOutcome],
    figures: Mapping[str, str],
    pictures: Mapping[tuple[str, str], bytes] | None = None,
    remark: str = "",
) -> str:
    """Return the page: methods side by side, figures, every problem by every method.

    Args:
        pictures: A thumbnail of each motion, by problem and method; none when None.
    """
    found = summaries(outcomes)
    problems = list(dict.fromkeys(run.problem for run in outcomes))
    drawn = "".join(
        f'<figure><img alt="{escape(caption)}" src="{uri}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
        for caption, uri in figures.items()
    )
    return document(
        "trajopt compare",
        COMPARISON_STYLE,
        f"<p>{in_number(found, 'method')} on {in_number(problems, 'problem')}: the same first guesses, the "
        "same budget, and the same judge, which shares no code with the planner. "
        f"{escape(remark)}</p>"
        f"{_html_table(SUMMARY_HEAD, [summary_cells(item) for item in found])}"
        f'<p class="faint">{escape(LEGEND)}</p>{drawn}<h2>Every problem</h2>'
        f'<p class="faint">Milliseconds of CPU; ✗ where planning did not end as it should.</p>'
        f"{_grid(outcomes, problems)}<h2>Every run</h2>"
        f"{''.join(_runs(outcomes, name, pictures or {}) for name in problems)}",
    )


def _html_table(head: Sequence[str], rows: Sequence[Sequence[str]], kind: str = "") -> str:
    numbers = [name for name in head if name not in TEXTS]
    return table(head, [[escape(cell) for cell in row] for row in rows], numbers=numbers, kind=kind)


def _grid(outcomes: Sequence[RunOutcome], problems: Sequence[str]) -> str:
    solvers = list(dict.fromkeys(run.solver for run in outcomes))
    known = {(run.problem, run.solver): run for run in outcomes}
    rows = [[escape(name), *(_cell(known.get((name, solver))) for solver in solvers)] for name in problems]
    return table(("problem", *solvers), rows, numbers=solvers, kind="grid")


def _cell(run: RunOutcome | None) -> str:
    if run is None:
        return ""
    kind, mark = ("good", "") if run.good else ("bad", " ✗")
    told = f"{status_words(run.status.name)}: {run.message}"
    return f'<span class="{kind}" title="{escape(told)}">{1000 * run.cpu_seconds:.0f}{mark}</span>'


def _runs(outcomes: Sequence[RunOutcome], problem: str, pictures: Mapping[tuple[str, str], bytes]) -> str:
    mine = [run for run in outcomes if run.problem == problem]
    good = sum(run.good for run in mine)
    kind = "good" if good == len(mine) else "bad"
    rows = [run_cells(run)[1:] for run in mine]
    drawn = {
        run.solver: (run, pictures[problem, run.solver]) for run in mine if (problem, run.solver) in pictures
    }
    best = min(drawn.values(), key=lambda item: (not item[0].good, item[0].duration or inf), default=None)
    motions = "".join(
        f"<figure>{image(picture, f'{problem}, {solver}')}<figcaption>{escape(solver)}"
        f"{'' if run.duration is None else f', {run.duration:.2f} s'}</figcaption></figure>"
        for solver, (run, picture) in drawn.items()
    )
    return (
        f"<details><summary>{'' if best is None else image(best[1])}<b>{escape(problem)}</b> "
        f'<span class="{kind}">{good} of {len(mine)}</span></summary>'
        f"{_html_table(RUN_HEAD[1:], rows, 'runs')}"
        f"{f'<div class=motions>{motions}</div>' if motions else ''}</details>"
    )


RUN_HEAD = (
    "problem", "solver", "outcome", "tries", "CPU ms", "steps", "cost", "motion s", "path", "clearance mm",
    "broken",
)  # fmt: skip
SUMMARY_HEAD = (
    "solver", "as expected", "CPU s in all", "CPU ms", "steps", "cost", "duration", "path",
    "clearance mm",
)  # fmt: skip
LEGEND = (
    "as expected: a motion that the judge verified, or the right refusal. CPU ms, steps: medians over "
    "solved problems. cost, duration, path: medians of the ratio to the best of all methods on the same "
    "problem. clearance: the smallest proven one."
)


def run_cells(run: RunOutcome) -> tuple[str, ...]:
    """Return a run's row under `RUN_HEAD`."""
    return (
        run.problem,
        run.solver,
        status_words(run.status.name) + ("" if run.good else " ✗"),
        str(run.attempts),
        f"{1000 * run.cpu_seconds:.0f}",
        str(run.iterations),
        _number(run.cost, ".3f"),
        _number(run.duration, ".2f"),
        _number(run.path_length, ".2f"),
        _number(run.clearance, ".1f", 1000.0),
        ", ".join(f"{name} by {size:.2g}" for name, size in run.violations.items()),
    )


def summary_cells(item: MethodSummary) -> tuple[str, ...]:
    """Return a method's row under `SUMMARY_HEAD`."""
    return (
        item.solver,
        f"{item.good} of {item.total}",
        f"{item.cpu_total:.1f}",
        _number(item.cpu_median, ".0f", 1000.0),
        _number(item.iterations, ".0f"),
        _number(item.cost, ".2f"),
        _number(item.duration, ".2f"),
        _number(item.path_length, ".2f"),
        _number(item.clearance, ".1f", 1000.0),
    )


def markdown(outcomes: Sequence[RunOutcome]) -> str:
    found = summaries(outcomes)
    groups = list(dict.fromkeys(name for item in found for name in item.groups))
    lines = [*_markdown_table(SUMMARY_HEAD, [summary_cells(item) for item in found]), "", LEGEND, ""]
    counted = [(item.solver, *(_share(item.groups.get(name, (0, 0))) for name in groups)) for item in found]
    lines += [*_markdown_table(("as expected", *groups), counted), "", "Not as expected:", ""]
    for item in found:
        failed = [run for run in outcomes if run.solver == item.solver and run.askable and not run.good]
        told = ", ".join(f"{run.problem} ({run.status.name})" for run in failed)
        lines.append(f"- **{item.solver}** ({len(failed)}): {told or 'none'}")
    return "\n".join(lines) + "\n"


def _markdown_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    return [f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows)]


def _share(counts: tuple[int, int]) -> str:
    return f"{counts[0]}/{counts[1]}"


def _number(value: float | None, form: str, factor: float = 1.0) -> str:
    return "" if value is None else format(value * factor, form)
