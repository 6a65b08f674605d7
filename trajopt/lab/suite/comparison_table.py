"""Outcomes and summaries as rows of text, for the command line, the page and Markdown alike."""

from collections.abc import Sequence

from trajopt.lab.suite.html import words
from trajopt.lab.suite.outcome import Outcome
from trajopt.lab.suite.summary import Summary, summaries

RUN_HEAD = (
    "problem", "solver", "outcome", "tries", "CPU ms", "steps", "cost", "motion s", "path", "clearance mm",
    "broken",
)  # fmt: skip
SUMMARY_HEAD = (
    "solver", "as expected", "CPU s in all", "CPU ms", "steps", "cost", "duration", "path",
    "clearance mm",
)  # fmt: skip
LEGEND = (
    "as expected: a motion that the judge verified, or the right refusal. CPU ms, steps: medians over what "
    "the method solved. cost, duration, path: medians of the ratio to the best of all methods on the same "
    "problem. clearance: the smallest that was proven."
)


def run_cells(run: Outcome) -> tuple[str, ...]:
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


def summary_cells(item: Summary) -> tuple[str, ...]:
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


def markdown(outcomes: Sequence[Outcome]) -> str:
    """Return tables: methods side by side, their successes by group, and what each did not solve."""
    found = summaries(outcomes)
    groups = list(dict.fromkeys(name for item in found for name in item.groups))
    lines = [*_table(SUMMARY_HEAD, [summary_cells(item) for item in found]), "", LEGEND, ""]
    counted = [(item.solver, *(_share(item.groups.get(name, (0, 0))) for name in groups)) for item in found]
    lines += [*_table(("as expected", *groups), counted), "", "Not as expected:", ""]
    for item in found:
        failed = [run for run in outcomes if run.solver == item.solver and run.askable and not run.good]
        told = ", ".join(f"{run.problem} ({run.status.name})" for run in failed)
        lines.append(f"- **{item.solver}** ({len(failed)}): {told or 'nothing'}")
    return "\n".join(lines) + "\n"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    return [f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows)]


def _share(counts: tuple[int, int]) -> str:
    return f"{counts[0]}/{counts[1]}"


def _number(value: float | None, form: str, factor: float = 1.0) -> str:
    return "" if value is None else format(value * factor, form)
