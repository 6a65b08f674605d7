"""The plane of a path and time as an image: what blocks which part of the path when, and the motion."""

# matplotlib leaves the type of its keyword arguments open.
# pyright: reportUnknownMemberType=false

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from trajopt.planning.moving.path_time import PathTime, forbidden_times
from trajopt.planning.result import Plan, Result
from trajopt.values.errors.arguments import checked
from trajopt.viewer.palette import LINES, hexadecimal
from trajopt.viewer.plots import DOTS_PER_INCH, image_path

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOTION = "#222222"
SHADE = 0.55
"""Opacity of what is blocked: the grid is seen through it."""


@checked
def plot_path_time(
    plan: Plan | Result, path: Path | str, *, until: float | None = None, title: str = ""
) -> Path:
    """Draw when each part of a plan's path is blocked, by what, and how the motion passes between.

    Where the line is level the robot waits, where it is steep it hurries; a region that is touched would be
    a collision. What is drawn is sampled (`trajopt.planning.forbidden_times`); what is proven is in the
    certificate.

    Args:
        plan: The plan, or a result that has one.
        path: The image to write; its suffix chooses the format (PNG where there is none).
        until: Until when time is shown [s]; when None, half as long again as the motion takes.
        title: Heading of the image.

    Returns:
        The path that was written.

    Raises:
        PlanningFailed: If the result has no plan.
        ShapeError: If the time is not positive.
        FileFormatError: If the suffix names no image format.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 5.0), dpi=DOTS_PER_INCH, layout="constrained")
    target = image_path(path, FigureCanvasAgg(figure).get_supported_filetypes())
    shown = forbidden_times(plan, until=until)
    axes = figure.add_subplot()
    _draw_regions(axes, shown)
    axes.plot(shown.chosen_times, 100.0 * shown.chosen_places, color=MOTION, linewidth=2.0, label="motion")
    end, last = float(shown.chosen_times[-1]), float(shown.times[-1])
    if end < last:
        axes.plot((end, last), (100.0, 100.0), color=MOTION, linewidth=2.0, linestyle=":", label="at its end")
    axes.set(xlim=(0.0, last), ylim=(-2.0, 102.0), xlabel="time [s]", ylabel="way along the path [%]")
    axes.grid(True, color="#e3e6ea", linewidth=0.7)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize="small")
    name = plan.require().problem.name
    figure.suptitle(title or f"{name or 'motion'}: {end:.2f} s", fontsize="x-large")
    figure.savefig(target)
    return target


def _draw_regions(axes: "Axes", shown: PathTime) -> None:
    """Fill the cells that something blocks, each thing in its colour; the links of a robot are one thing."""
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
