"""Plots of motions, blocked intervals, reach maps and comparisons, as images."""

# matplotlib leaves the type of its keyword arguments open.
# pyright: reportUnknownMemberType=false

from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from trajopt.lab.reach import CAUSES, CurveMap, ReachMap
from trajopt.lab.suite import RunOutcome
from trajopt.lab.suite.outcome import performance_profile
from trajopt.planning.moving.path_time import PathTime, forbidden_times
from trajopt.planning.result import Plan, Result
from trajopt.problem.requirements import Requirement
from trajopt.robot.joints import JointLimits
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Bools, Floats
from trajopt.values.errors import FileFormatError, ShapeError
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Interpolation, Trajectory
from trajopt.viewer.clearance import REACH, ClearanceKind, MotionSamples, sample_motion
from trajopt.viewer.palette import LINES, NARROW, TOUCHING, hexadecimal
from trajopt.viewer.readout import decimal

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage

DOTS_PER_INCH = 150
LIMIT = hexadecimal(TOUCHING)
MARGIN = hexadecimal(NARROW)
KIND_COLOURS = dict(zip(ClearanceKind, (LINES[0], LINES[5], LINES[2]), strict=True))


@checked
def plot_motion(
    reduced: ReducedModel,
    trajectory: Trajectory,
    path: Path | str,
    *,
    limits: JointLimits | None = None,
    constraints: Sequence[Requirement] = (),
    title: str = "",
) -> Path:
    """Draw a motion over time: positions, speeds, clearance, and tilt or accelerations; return the path.

    Args:
        constraints: Path constraints; axis alignments are drawn.

    Raises:
        ShapeError: If the trajectory moves other joints than the group's.
        FileFormatError: If the suffix is not an image format.
    """
    if trajectory.joint_names != reduced.joint_names:
        raise ShapeError("trajectory", f"moves {trajectory.joint_names}, the group is {reduced.joint_names}")
    figure, target = _figure_for(path, 10.0, 11.0)
    samples = sample_motion(reduced, trajectory, limits or reduced.limits, constraints)
    panels: list[Axes] = list(figure.subplots(4, 1, sharex=True))
    _draw_positions(panels[0], samples)
    _draw_shares(panels[1], samples, samples.velocity_shares, "joint speed\n[% of limit]")
    _draw_clearance(panels[2], samples)
    if samples.tilts:
        _draw_tilts(panels[3], samples)
    else:
        _draw_shares(panels[3], samples, samples.acceleration_shares, "joint acceleration\n[% of limit]")
        if trajectory.interpolation is Interpolation.LINEAR:
            note = "linear between its points: acceleration is zero there, and not defined at them"
            panels[3].set_title(note, loc="left", fontsize="small", color="#555555")
    for panel in panels:
        _finish(panel)
        if panel.get_legend_handles_labels()[0]:
            _legend_beside(panel)
    panels[-1].set_xlabel("time [s]")
    panels[-1].set_xlim(0.0, trajectory.duration)
    figure.align_ylabels(panels)
    figure.suptitle(title or f"{reduced.scene.robot.name}: {trajectory.duration:.2f} s", fontsize="x-large")
    figure.savefig(target)
    return target


def _figure_for(path: Path | str, width: float, height: float) -> "tuple[Figure, Path]":
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=DOTS_PER_INCH, layout="constrained")
    return figure, image_path(path, FigureCanvasAgg(figure).get_supported_filetypes())


def image_path(path: Path | str, known: Iterable[str]) -> Path:
    target = Path(path) if Path(path).suffix else Path(path).with_suffix(".png")
    if target.suffix[1:].lower() not in known:
        raise FileFormatError(str(target), f"is not an image format; known: {', '.join(sorted(known))}")
    return target


def _draw_joints(axes: "Axes", samples: MotionSamples, values: Floats, *, labelled: bool) -> None:
    for joint, name in enumerate(samples.joint_names):
        label = f"{name} (no limits: half turns)" if name in samples.unlimited else name
        axes.plot(
            samples.times,
            values[:, joint],
            color=hexadecimal(LINES[joint % len(LINES)]),
            linestyle=("-", "--", ":", "-.")[joint // len(LINES) % 4],
            linewidth=1.6,
            label=label if labelled else None,
        )


def _draw_positions(axes: "Axes", samples: MotionSamples) -> None:
    _draw_joints(axes, samples, samples.position_shares, labelled=True)
    extent = max(1.1, 1.05 * float(np.abs(samples.position_shares).max()))
    axes.set_ylim(-extent, extent)
    _bounds(axes, 1.0, "limit")
    axes.set_ylabel("joint position\n[lower limit -1, upper 1]")


def _draw_shares(axes: "Axes", samples: MotionSamples, shares: Floats, label: str) -> None:
    _draw_joints(axes, samples, 100.0 * shares, labelled=False)
    extent = max(110.0, 105.0 * float(np.abs(shares).max()))
    axes.set_ylim(-extent, extent)
    _bounds(axes, 100.0, "limit")
    axes.set_ylabel(label)


def _draw_clearance(axes: "Axes", samples: MotionSamples) -> None:
    unit, top = 1000.0, 1000.0 * REACH
    linear = max([1.0, *(unit * margin for margin in samples.margins)])
    lowest = 0.0
    for kind, smallest in samples.clearances.items():
        shown = np.minimum(unit * smallest, top)
        lowest = min(lowest, float(shown.min()))
        axes.plot(
            samples.clearance_times,
            shown,
            color=hexadecimal(KIND_COLOURS[kind]),
            linewidth=1.8,
            label=kind.value,
        )
    bottom = min(1.3 * lowest, -0.3 * linear)
    axes.set_yscale("asinh", linear_width=linear)
    axes.set_ylim(bottom, 1.25 * top)
    rounds = (-300.0, -100.0, -30.0, -10.0, -3.0, 0.0, 3.0, 10.0, 30.0, 100.0)
    ticks = [tick for tick in rounds if tick >= bottom and (tick == 0.0 or abs(tick) >= 0.5 * linear)]
    axes.set_yticks([*ticks, top], [*(f"{tick:g}" for tick in ticks), f"{top:g}+"])
    axes.minorticks_off()
    axes.axhspan(-1e6, 0.0, color=LIMIT, alpha=0.08, linewidth=0.0)
    axes.axhline(0.0, color=LIMIT, linewidth=1.0, label="contact")
    for values, colour, name in ((samples.required, LIMIT, "required"), (samples.margins, MARGIN, "margin")):
        for value in values:
            label = f"{name} {unit * value:g} mm"
            axes.axhline(unit * value, color=colour, linestyle="--", linewidth=1.2, label=label)
    for begin, end, name in samples.windows:
        axes.axvspan(
            begin, end, color="#9aa3ad", alpha=0.18, linewidth=0.0, label=f"intended contact: {name}"
        )
    if samples.tightest is not None:
        at, value, names = samples.tightest
        axes.plot([at], [unit * value], "o", color="#222222", markersize=4.5)
        left = at > 0.6 * samples.times[-1]
        axes.annotate(
            f"{decimal(unit * value)} mm: {names[0]} – {names[1]}",
            (at, unit * value),
            xytext=(-8 if left else 8, 10),
            textcoords="offset points",
            ha="right" if left else "left",
            fontsize="small",
            bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.8},
        )
    axes.set_ylabel("smallest clearance\n[mm]")


def _draw_tilts(axes: "Axes", samples: MotionSamples) -> None:
    top = 0.0
    for number, tilt in enumerate(samples.tilts):
        colour = hexadecimal(LINES[number % len(LINES)])
        angles, bound = np.degrees(tilt.angles), float(np.degrees(tilt.bound))
        axes.plot(samples.times, angles, color=colour, linewidth=1.8, label=f"tilt of {tilt.frame}")
        axes.axhline(bound, color=colour, linestyle="--", linewidth=1.2, label=f"bound {bound:.3g}°")
        top = max(top, bound, float(angles.max()))
    axes.set_ylim(-0.04 * top, 1.15 * top)
    axes.set_ylabel("tilt\n[deg]")


def _bounds(axes: "Axes", bound: float, label: str) -> None:
    axes.axhline(bound, color=LIMIT, linestyle="--", linewidth=1.1, label=label)
    axes.axhline(-bound, color=LIMIT, linestyle="--", linewidth=1.1)


MOTION = "#222222"
SHADE = 0.55
"""Opacity of blocked regions, fainter than the grid."""


@checked
def plot_path_time(
    plan: Plan | Result, path: Path | str, *, until: float | None = None, title: str = ""
) -> Path:
    """Draw when each part of a plan's path is blocked, by which obstacle, and how the motion passes.

    The robot waits on level parts of the line and hurries on steep ones. The regions are sampled
    (`trajopt.planning.forbidden_times`).

    Args:
        until: End of the time axis [s]; 1.5 times the duration of the motion if None.

    Raises:
        ShapeError: If the time is not positive.
        FileFormatError: If the suffix is not an image format.
    """
    figure, target = _figure_for(path, 8.0, 5.0)
    shown = forbidden_times(plan, until=until)
    axes = figure.add_subplot()
    _draw_regions(axes, shown)
    axes.plot(shown.chosen_times, 100.0 * shown.chosen_places, color=MOTION, linewidth=2.0, label="motion")
    end, last = float(shown.chosen_times[-1]), float(shown.times[-1])
    if end < last:
        axes.plot((end, last), (100.0, 100.0), color=MOTION, linewidth=2.0, linestyle=":", label="at its end")
    axes.set(xlim=(0.0, last), ylim=(-2.0, 102.0), xlabel="time [s]", ylabel="way along the path [%]")
    _finish(axes)
    _legend_beside(axes)
    name = plan.require().problem.name
    figure.suptitle(title or f"{name or 'motion'}: {end:.2f} s", fontsize="x-large")
    figure.savefig(target)
    return target


def _draw_regions(axes: "Axes", shown: PathTime) -> None:
    things = dict.fromkeys(name.split("/")[0] for name in shown.objects)
    picture = np.zeros((*shown.blocked.shape, 4))
    for count, thing in enumerate(things):
        mine = [place for place, name in enumerate(shown.objects) if name.split("/")[0] == thing]
        cells = np.isin(shown.blocked, mine)
        if cells.any():
            colour = LINES[count % len(LINES)]
            picture[cells] = (*(share / 255 for share in colour), SHADE)
            label = f"{thing} in the way"
            axes.fill_between([], [], [], color=hexadecimal(colour), alpha=SHADE, label=label)
    axes.pcolormesh(shown.times, 100.0 * shown.places, picture, linewidth=0.0, rasterized=True)


AXES = ("x", "y", "z")
UPRIGHT = 2
CUTS = ((1, 0, 2), (0, 1, 2), (2, 0, 1))
"""Axis normal to each cut, then the axes to the right and upward in it."""


@checked
def plot_reach(reach: ReachMap, path: Path | str) -> Path:
    """Draw three cuts through the middle of a reach map, twice; return the path.

    The upper row shows the share of directions from which a cell was reached, the lower one the largest
    manipulability in it; unreached cells are white. The upright cuts go through the origin (a cross) if it is
    inside, the level one through the layer with most directions.

    Raises:
        FileFormatError: If the suffix is not an image format.
    """
    figure, target = _figure_for(path, 13.0, 8.5)
    layers = (
        ("directions met [%]", 100.0 * reach.reachability_index),
        ("largest manipulability", reach.manipulability),
    )
    panels = figure.subplots(2, 3)
    for row, (label, values) in zip(panels, layers, strict=True):
        images = [
            _draw_cut(axes, reach, values, cut, top=float(values.max()))
            for axes, cut in zip(row, CUTS, strict=True)
        ]
        figure.colorbar(images[-1], ax=list(row), label=label, shrink=0.9)
    figure.suptitle(
        f"{reach.frame} of {reach.robot}: {reach.volume:.2f} m³ in cells of {1000.0 * reach.cell:g} mm, "
        f"{reach.valid} configurations",
        fontsize="x-large",
    )
    figure.savefig(target)
    return target


REACH_COLOURS = ("#4c9f70", "#f2c14e", "#c8553d", "#c9ced6")
"""Of `CAUSES`."""


@checked
def plot_curve_map(reach: CurveMap, path: Path | str) -> Path:
    """Draw the reach along a curve, position by spin, coloured by cause; return the path.

    Raises:
        FileFormatError: If the suffix is not an image format.
    """
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    figure, target = _figure_for(path, 9.0, 5.0)
    axes = figure.subplots()
    axes.pcolormesh(
        reach.lengths,
        np.degrees(reach.spins),
        reach.cells.T,
        shading="nearest",
        cmap=ListedColormap(REACH_COLOURS),
        vmin=-0.5,
        vmax=len(CAUSES) - 0.5,
    )
    axes.set_xlabel("position along the curve [m]")
    axes.set_ylabel(f"spin of {reach.frame} [deg]")
    axes.set_title(str(reach), loc="left", fontsize="medium")
    patches = [
        Patch(facecolor=colour, label=cause.value)
        for colour, cause in zip(REACH_COLOURS, CAUSES, strict=True)
    ]
    axes.legend(handles=patches, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=4, frameon=False)
    figure.savefig(target)
    return target


def _draw_cut(
    axes: "Axes", reach: ReachMap, values: Floats, cut: tuple[int, int, int], *, top: float
) -> "AxesImage":
    across, right, up = cut
    through_origin = reach.cell_of(np.zeros(3))
    fullest = int(np.argmax(reach.reached.sum(axis=(right, up))))
    layer = fullest if through_origin is None or across == UPRIGHT else through_origin[across]
    shown: Floats = np.take(values, layer, axis=across)
    met: Bools = np.take(reach.hits, layer, axis=across) > 0
    low, high = reach.origin, reach.origin + reach.cell * np.array(reach.hits.shape)
    image = axes.imshow(
        np.ma.masked_array(shown, ~met).T,
        origin="lower",
        extent=(low[right], high[right], low[up], high[up]),
        vmin=0.0,
        vmax=top or 1.0,
        cmap="viridis",
        interpolation="nearest",
    )
    axes.set_title(f"{AXES[across]} = {reach.centres(across)[layer]:.2f} m", loc="left", fontsize="medium")
    axes.set_xlabel(f"{AXES[right]} [m]")
    axes.set_ylabel(f"{AXES[up]} [m]")
    axes.plot(0.0, 0.0, marker="+", color="#d62728", markersize=9, markeredgewidth=1.5)
    axes.spines[["top", "right"]].set_visible(False)
    return image


PANELS = 6
"""Most problems with a panel of their own."""
HELD = 1e-6
"""Violations below this are drawn here: zero has no logarithm."""
DASHES = ("-", "--", ":", "-.")
HISTORIES = (
    "Violation at the current point against CPU time, over all seeds; a dot where a motion was "
    "verified in the end, a cross where not"
)
WIDTH = 10.0


def comparison_figures(runs: Sequence[RunOutcome]) -> Mapping[str, str]:
    """Draw a comparison: caption -> PNG as a data URI; paths only if there are any."""
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


def _profile(runs: Sequence[RunOutcome], styles: Mapping[str, tuple[str, str]]) -> "Figure":
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
        _legend_beside(axes)
    return figure


def _histories(
    runs: Sequence[RunOutcome], problems: Sequence[str], styles: Mapping[str, tuple[str, str]]
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
        low, high = panel.get_xlim()
        ticks = sorted({float(f"{place:.1g}") for place in np.geomspace(low, high, 5)[1:-1]})
        panel.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        panel.set_xticks([], minor=True)
        panel.set_ylabel("violation (L1)")
        _finish(panel)
    _legend(figure, panels, len(problems))
    return figure


def _paths(
    runs: Sequence[RunOutcome], problems: Sequence[str], styles: Mapping[str, tuple[str, str]]
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


def _chosen(runs: Sequence[RunOutcome]) -> list[str]:
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


def _legend_beside(axes: "Axes") -> None:
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize="small")


def _finish(axes: "Axes") -> None:
    axes.grid(True, color="#e3e6ea", linewidth=0.7)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def _uri(figure: "Figure") -> str:
    buffer = BytesIO()
    figure.savefig(buffer, format="png")
    return f"data:image/png;base64,{b64encode(buffer.getvalue()).decode()}"
