"""A comparison as images: performance profile, violation against CPU time, paths side by side."""

# matplotlib leaves the type of its keyword arguments open.
# pyright: reportUnknownMemberType=false

from base64 import b64encode
from collections.abc import Mapping, Sequence
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

from trajopt.lab.suite import Outcome
from trajopt.lab.suite.summary import performance_profile
from trajopt.values.arrays import Floats
from trajopt.viewer.palette import LINES, hexadecimal

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANELS = 6
"""Largest number of problems with a panel of their own."""
HELD = 1e-6
"""Violations below this are drawn here: zero has no logarithm."""
DASHES = ("-", "--", ":", "-.")
HISTORIES = (
    "Violation at the current point against CPU time, over all seeds; a dot where a motion was "
    "verified in the end, a cross where not"
)
WIDTH = 10.0
"""Of every figure [inch]."""


def comparison_figures(runs: Sequence[Outcome]) -> Mapping[str, str]:
    """Draw a comparison.

    Args:
        runs: The runs of all methods.

    Returns:
        Caption -> PNG as a data URI; paths only if there are any.
    """
    styles = {
        solver: (hexadecimal(LINES[number % len(LINES)]), DASHES[number // len(LINES) % len(DASHES)])
        for number, solver in enumerate(dict.fromkeys(run.solver for run in runs))
    }
    figures = {
        "Performance profile: the share of problems solved within a factor of the best method's CPU time "
        "(Dolan and Moré, 2002)": _profile(runs, styles)
    }
    stepped = _chosen([run for run in runs if run.history])
    if stepped:
        figures[HISTORIES] = _histories(runs, stepped, styles)
    moved = _chosen([run for run in runs if run.tip and run.verified])
    if moved:
        figures["Verified paths of the last joint: from above and from the side"] = _paths(
            runs, moved, styles
        )
    return {caption: _uri(figure) for caption, figure in figures.items()}


def _profile(runs: Sequence[Outcome], styles: Mapping[str, tuple[str, str]]) -> "Figure":
    figure = _figure(4.6)
    axes = figure.subplots()
    profile = performance_profile(runs)
    finite = [ratios[np.isfinite(ratios)] for ratios in profile.values()]
    farthest = 1.3 * max((float(ratios[-1]) for ratios in finite if len(ratios)), default=2.0)
    for solver, ratios in profile.items():
        solved = ratios[np.isfinite(ratios)]
        share = np.arange(1, len(solved) + 1) / max(len(ratios), 1)
        end = share[-1] if len(share) else 0.0
        axes.step(
            np.concatenate(([1.0], solved, [farthest])), 100.0 * np.concatenate(([0.0], share, [end])),
            where="post", color=styles[solver][0], linestyle=styles[solver][1], linewidth=1.8, label=solver,
        )  # fmt: skip
    axes.set_xscale("log", base=2)
    axes.set_xlim(1.0, max(farthest, 2.0))
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.set_ylim(0.0, 103.0)
    axes.set_xlabel("CPU time, as a multiple of the fastest method's on the same problem")
    axes.set_ylabel("problems solved [%]")
    _finish(axes)
    if profile:
        axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize="small")
    return figure


def _histories(
    runs: Sequence[Outcome], problems: Sequence[str], styles: Mapping[str, tuple[str, str]]
) -> "Figure":
    columns = min(3, len(problems))
    rows = -(-len(problems) // columns)
    figure = _figure(3.1 * rows + 0.6)
    panels = _panels(figure, rows, columns)
    for panel, problem in zip(panels, problems, strict=False):
        for run in runs:
            if run.problem != problem or not run.history:
                continue
            colour, dash = styles[run.solver]
            time = [1000.0 * moment.cpu_seconds for moment in run.history]
            size = [max(moment.violation, HELD) for moment in run.history]
            panel.plot(time, size, color=colour, linestyle=dash, linewidth=1.3, label=run.solver)
            panel.plot(time[-1:], size[-1:], "o" if run.verified else "x", color=colour, markersize=5.0)
        panel.set_xscale("log")
        panel.set_yscale("log")
        panel.set_title(problem, fontsize="medium", loc="left")
        panel.set_xlabel("CPU time [ms]")
        _few_ticks(panel)
        panel.set_ylabel("violation (L1)")
        _finish(panel)
    _legend(figure, panels, len(problems))
    return figure


def _paths(
    runs: Sequence[Outcome], problems: Sequence[str], styles: Mapping[str, tuple[str, str]]
) -> "Figure":
    figure = _figure(5.6)
    panels = _panels(figure, 2, len(problems))
    for column, problem in enumerate(problems):
        for row, (across, up) in enumerate(((0, 1), (0, 2))):
            panel = panels[row * len(problems) + column]
            for run in runs:
                if run.problem == problem and run.verified and run.tip:
                    tip: Floats = np.array(run.tip)
                    panel.plot(
                        tip[:, across], tip[:, up], color=styles[run.solver][0],
                        linestyle=styles[run.solver][1], linewidth=1.5, label=run.solver,
                    )  # fmt: skip
                    panel.plot(tip[[0, -1], across], tip[[0, -1], up], ".", color="#222222", markersize=4.0)
            panel.set_aspect("equal", adjustable="datalim")
            panel.tick_params(labelsize="x-small")
            panel.set_xlabel("x [m]", fontsize="small")
            if column == 0:
                panel.set_ylabel(f"{'xyz'[up]} [m]", fontsize="small")
            if row == 0:
                panel.set_title(problem, fontsize="x-small", loc="left")
            _finish(panel)
    _legend(figure, panels, len(panels))
    return figure


def _chosen(runs: Sequence[Outcome]) -> list[str]:
    """Return a few problems, spread over those with results of most methods."""
    counts: dict[str, int] = {}
    for run in runs:
        counts[run.problem] = counts.get(run.problem, 0) + 1
    most = [name for name in counts if counts[name] == max(counts.values())]
    places = np.linspace(0, len(most) - 1, min(PANELS, len(most))).round().astype(np.int64)
    return [most[place] for place in places]


def _figure(height: float) -> "Figure":
    from matplotlib.figure import Figure

    return Figure(figsize=(WIDTH, height), dpi=110, layout="constrained")


def _panels(figure: "Figure", rows: int, columns: int) -> "list[Axes]":
    grid = figure.subplots(rows, columns, squeeze=False)
    return [axes for line in grid for axes in line]


def _legend(figure: "Figure", panels: "Sequence[Axes]", used: int) -> None:
    """Name every method once, below all panels; hide panels that nothing is drawn in."""
    for panel in panels[used:]:
        panel.set_visible(False)
    named: dict[str, Artist] = {}
    for panel in panels:
        handles, labels = panel.get_legend_handles_labels()
        named.update(zip(labels, handles, strict=True))
    figure.legend(
        list(named.values()), list(named),
        loc="outside lower center", ncols=7, frameon=False, fontsize="small",
    )  # fmt: skip


def _few_ticks(axes: "Axes") -> None:
    """Label a logarithmic axis of times at a few round values only."""
    low, high = axes.get_xlim()
    ticks = sorted({float(f"{place:.1g}") for place in np.geomspace(low, high, 5)[1:-1]})
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_xticks([], minor=True)


def _finish(axes: "Axes") -> None:
    axes.grid(True, color="#e3e6ea", linewidth=0.7)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def _uri(figure: "Figure") -> str:
    buffer = BytesIO()
    figure.savefig(buffer, format="png")
    return f"data:image/png;base64,{b64encode(buffer.getvalue()).decode()}"
