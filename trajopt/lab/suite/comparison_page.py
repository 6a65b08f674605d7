"""A comparison as one HTML page that needs nothing beside itself."""

from collections.abc import Mapping, Sequence
from html import escape
from math import inf

from trajopt.lab.suite.comparison_table import LEGEND, RUN_HEAD, SUMMARY_HEAD, run_cells, summary_cells
from trajopt.lab.suite.html import document, image, table, words
from trajopt.lab.suite.outcome import Outcome
from trajopt.lab.suite.summary import summaries

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
    outcomes: Sequence[Outcome],
    figures: Mapping[str, str],
    pictures: Mapping[tuple[str, str], bytes] | None = None,
    remark: str = "",
) -> str:
    """Return the page: methods side by side, figures, every problem by every method.

    Args:
        outcomes: The outcomes.
        figures: Caption -> the figure as a data URI.
        pictures: A thumbnail of each motion, by problem and method; none when None.
        remark: A sentence that is added to the head of the page.
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
        "the same judge, who shares no code with what it judges. "
        f"{escape(remark)}</p>"
        f"{_table(SUMMARY_HEAD, [summary_cells(item) for item in found])}"
        f'<p class="faint">{escape(LEGEND)}</p>{drawn}<h2>Every problem</h2>'
        f'<p class="faint">Milliseconds of CPU; ✗ where planning did not end as it should.</p>'
        f"{_grid(outcomes, problems)}<h2>Every run</h2>"
        f"{''.join(_runs(outcomes, name, pictures or {}) for name in problems)}",
    )


def _table(head: Sequence[str], rows: Sequence[Sequence[str]], kind: str = "") -> str:
    numbers = [name for name in head if name not in TEXTS]
    return table(head, [[escape(cell) for cell in row] for row in rows], numbers=numbers, kind=kind)


def _grid(outcomes: Sequence[Outcome], problems: Sequence[str]) -> str:
    solvers = list(dict.fromkeys(run.solver for run in outcomes))
    known = {(run.problem, run.solver): run for run in outcomes}
    rows = [[escape(name), *(_cell(known.get((name, solver))) for solver in solvers)] for name in problems]
    return table(("problem", *solvers), rows, numbers=solvers, kind="grid")


def _cell(run: Outcome | None) -> str:
    if run is None:
        return ""
    kind, mark = ("good", "") if run.good else ("bad", " ✗")
    told = f"{words(run.status)}: {run.message}"
    return f'<span class="{kind}" title="{escape(told)}">{1000 * run.cpu_seconds:.0f}{mark}</span>'


def _runs(outcomes: Sequence[Outcome], problem: str, pictures: Mapping[tuple[str, str], bytes]) -> str:
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
        f'<span class="{kind}">{good} of {len(mine)}</span></summary>{_table(RUN_HEAD[1:], rows, "runs")}'
        f"{f'<div class=motions>{motions}</div>' if motions else ''}</details>"
    )
