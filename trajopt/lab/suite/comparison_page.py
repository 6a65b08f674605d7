"""A comparison as a self-contained HTML page, or as text."""

from collections.abc import Mapping, Sequence
from html import escape
from math import inf

from trajopt.lab.suite.html import document, image, table, words
from trajopt.lab.suite.outcome import MethodSummary, RunOutcome, summaries

STYLE = """
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
"""Columns that hold words; all others hold numbers."""


def page(
    outcomes: Sequence[RunOutcome],
    figures: Mapping[str, str],
    pictures: Mapping[tuple[str, str], bytes] | None = None,
    remark: str = "",
) -> str:
    """Return the page: methods side by side, figures, every problem by every method.

    Args:
        figures: Caption -> the figure as a data URI.
        pictures: A thumbnail of each motion, by problem and method; none when None.
        remark: A sentence for the head of the page.
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
        STYLE,
        f"<p>{len(found)} methods on {len(problems)} problems: the same first guesses, the same budget, and "
        "the same judge, which shares no code with the planner. "
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
    told = f"{words(run.status)}: {run.message}"
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
        words(run.status) + ("" if run.good else " ✗"),
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
    """Return tables: methods side by side, their successes by group, and the unsolved problems of each."""
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
