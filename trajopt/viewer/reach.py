"""A reach map as an image: cuts through its middle, by directions met and by manipulability."""

# matplotlib leaves the type of its keyword arguments open.
# pyright: reportUnknownMemberType=false

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from trajopt.lab.reach import ReachMap
from trajopt.values.arrays import Bools, Floats
from trajopt.values.errors.arguments import checked
from trajopt.viewer.plots import DOTS_PER_INCH, image_path

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.image import AxesImage

AXES = ("x", "y", "z")
UPRIGHT = 2
CUTS = ((1, 0, 2), (0, 1, 2), (2, 0, 1))
"""Axis that each cut is across, then the axes to the right and upward in it."""


@checked
def plot_reach(reach: ReachMap, path: Path | str) -> Path:
    """Draw three cuts through the middle of a reach map, twice.

    The upper row shows the share of directions that a cell was met from, the lower one the largest
    manipulability in it; cells that were not met are white. The upright cuts go through the origin (a cross)
    where it is inside, the level one through the layer with most directions met.

    Args:
        reach: The map.
        path: The image to write; its suffix chooses the format (PNG where there is none).

    Returns:
        The path that was written.

    Raises:
        FileFormatError: If the suffix names no image format.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13.0, 8.5), dpi=DOTS_PER_INCH, layout="constrained")
    target = image_path(path, FigureCanvasAgg(figure).get_supported_filetypes())
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


def _draw_cut(
    axes: "Axes", reach: ReachMap, values: Floats, cut: tuple[int, int, int], *, top: float
) -> "AxesImage":
    """Draw one layer of cells and return its image."""
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
