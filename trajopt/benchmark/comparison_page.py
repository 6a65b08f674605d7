"""A comparison as one HTML page that needs nothing beside itself."""

from collections.abc import Mapping, Sequence
from html import escape

from trajopt.benchmark.comparison_table import LEGEND, RUN_HEAD, SUMMARY_HEAD, run_cells, summary_cells
from trajopt.benchmark.run import Run
from trajopt.benchmark.summary import summaries

STYLE = """
:root { color-scheme: light dark; --line: #8884; --good: #1a7f37; --bad: #cf222e; --soft: #8881; }
body { font: 15px/1.45 system-ui, sans-serif; max-width: 84rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; margin-bottom: .2rem; } h2 { font-size: 1.15rem; margin: 2rem 0 .5rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; width: 100%; }
th, td { text-align: right; padding: .2rem .6rem; border-top: 1px solid var(--line); vertical-align: top;
  white-space: nowrap; }
th:first-child, td:first-child, .runs td:nth-child(2), .runs td:nth-child(1), .runs td:last-child {
  text-align: left; }
.runs td:last-child, .runs th:last-child { text-align: left; white-space: normal; min-width: 12rem; }
.grid td:first-child { width: 40%; } .grid th { font-weight: 600; writing-mode: vertical-rl; text-align: left;
  padding: .4rem .5rem; } .grid th:first-child { writing-mode: horizontal-tb; }
.good { color: var(--good); } .bad { color: var(--bad); } .faint { opacity: .7; }
tbody tr:nth-child(even) { background: var(--soft); }
figure { margin: 0 0 1.5rem; } figure img { max-width: 100%; height: auto; background: white;
  border: 1px solid var(--line); border-radius: 6px; } figcaption { opacity: .8; font-size: .9rem; }
details { border: 1px solid var(--line); border-radius: 6px; margin: .4rem 0; padding: 0 .8rem; }
summary { cursor: pointer; padding: .45rem 0; }
"""


def page(runs: Sequence[Run], figures: Mapping[str, str]) -> str:
    """Return the page: methods side by side, figures, every problem by every method.

    Args:
        runs: The runs.
        figures: Caption -> the figure as a data URI.
    """
    found = summaries(runs)
    problems = list(dict.fromkeys(run.problem for run in runs))
    drawn = "".join(
        f'<figure><img alt="{escape(caption)}" src="{uri}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
        for caption, uri in figures.items()
    )
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width"><title>trajopt compare</title>'
        f"<style>{STYLE}</style></head><body><h1>trajopt compare</h1><p>{len(found)} methods on "
        f"{len(problems)} problems: the same first guesses, the same budget, and the same judge, who shares "
        f"no code with what it judges.</p>{_table(SUMMARY_HEAD, [summary_cells(item) for item in found])}"
        f'<p class="faint">{escape(LEGEND)}</p>{drawn}<h2>Every problem</h2>'
        f'<p class="faint">Milliseconds of CPU; ✗ where planning did not end as it should.</p>'
        f"{_grid(runs, problems)}<h2>Every run</h2>{''.join(_runs(runs, name) for name in problems)}"
        "</body></html>\n"
    )


def _table(head: Sequence[str], rows: Sequence[Sequence[str]], kind: str = "") -> str:
    titles = "".join(f"<th>{escape(name)}</th>" for name in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return (
        f'<div class="wide"><table class="{kind}"><thead><tr>{titles}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def _grid(runs: Sequence[Run], problems: Sequence[str]) -> str:
    solvers = list(dict.fromkeys(run.solver for run in runs))
    known = {(run.problem, run.solver): run for run in runs}
    head = "".join(f"<th>{escape(name)}</th>" for name in ("problem", *solvers))
    rows = "".join(
        f"<tr><td>{escape(name)}</td>{''.join(_cell(known.get((name, solver))) for solver in solvers)}</tr>"
        for name in problems
    )
    return (
        f'<div class="wide"><table class="grid"><thead><tr>{head}</tr></thead>'
        f"<tbody>{rows}</tbody></table></div>"
    )


def _cell(run: Run | None) -> str:
    if run is None:
        return "<td></td>"
    told = run.status.name.replace("_", " ").lower()
    text = f"{1000 * run.cpu_seconds:.0f}"
    kind, mark = ("good", "") if run.good else ("bad", " ✗")
    return f'<td class="{kind}" title="{escape(told)}: {escape(run.message)}">{text}{mark}</td>'


def _runs(runs: Sequence[Run], problem: str) -> str:
    mine = [run for run in runs if run.problem == problem]
    good = sum(run.good for run in mine)
    kind = "good" if good == len(mine) else "bad"
    rows = [run_cells(run)[1:] for run in mine]
    return (
        f"<details><summary><b>{escape(problem)}</b> "
        f'<span class="{kind}">{good} of {len(mine)}</span></summary>{_table(RUN_HEAD[1:], rows, "runs")}'
        "</details>"
    )
