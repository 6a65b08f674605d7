"""Plots as SVG: curves over time, and strips that say when something is so."""

from collections.abc import Callable, Sequence
from html import escape

import numpy as np

from trajopt.values.arrays import Floats
from trajopt.values.printed import in_short
from trajopt.viewer.palette import LINES, hexadecimal
from trajopt.viewer.report.measured import Binding, Chart

WIDTH, HEIGHT = 960, 190
"""Of a plot, in its own units; it is drawn as wide as the page."""
LEFT, RIGHT, TOP, BOTTOM = 46, 8, 8, 24
"""Around the curves."""
STRIP = 20
"""Height of a strip."""
NAMES = 260
"""Width of the names of strips."""
LONGEST = 40
"""Characters of a name beside its strip."""
DASHES = ("", "6 3", "2 3", "8 3 2 3")
"""Of curves whose colours are used already."""
TICKS = 5
"""About as many as there are on an axis."""
Place = Callable[[float], float]
"""Where a time or a value is drawn."""


def plot(chart: Chart) -> str:
    """Return a plot and its legend, in HTML."""
    lower, upper = _range(chart)
    end = float(chart.times[-1])
    left, right = LEFT, WIDTH - RIGHT

    def x(time: float) -> float:
        return left + (right - left) * time / end

    def y(value: float) -> float:
        return TOP + (HEIGHT - TOP - BOTTOM) * (upper - value) / (upper - lower)

    grid = [
        f'<line class="grid" x1="{left}" x2="{right}" y1="{y(tick):.1f}" y2="{y(tick):.1f}"/>'
        f'<text class="tick" x="{left - 6}" y="{y(tick) + 4:.1f}" text-anchor="end">{tick:g}</text>'
        for tick in ticks(lower, upper)
    ]
    limits = [
        f'<line class="limit {"soft" if name == "margin" else ""}" x1="{left}" x2="{right}" '
        f'y1="{y(value):.1f}" y2="{y(value):.1f}"><title>{escape(name)} {value:g} {escape(chart.unit)}'
        f'</title></line><text class="limit-name" x="{right - 4}" y="{y(value) - 4:.1f}" text-anchor="end">'
        f"{escape(name)}</text>"
        for value, name in chart.limits
        if lower <= value <= upper
    ]
    curves = [
        f'<path class="curve" style="{_stroke(number)}" d="{_path(chart.times, line.values, x, y, upper)}"/>'
        for number, line in enumerate(chart.lines)
    ]
    legend = "".join(
        f'<li><svg viewBox="0 0 22 8" aria-hidden="true"><path class="curve" style="{_stroke(number)}" '
        f'd="M1 4H21"/></svg><span>{escape(line.name)}</span> <b></b></li>'
        for number, line in enumerate(chart.lines)
    )
    return (
        f'<figure class="chart"><figcaption>{escape(chart.title)} '
        f'<span class="faint">[{escape(chart.unit)}]</span></figcaption>'
        f'<svg class="plot" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{escape(chart.title)}" '
        f'data-left="{left}" data-right="{right}" data-end="{end:.9g}" data-top="{y(upper):g}" '
        f'data-bottom="{y(lower):g}" data-upper="{upper:.9g}" data-lower="{lower:.9g}">'
        f"{''.join(grid)}{_axis(end, x)}{''.join(limits)}{''.join(curves)}{_cursor(HEIGHT - BOTTOM)}</svg>"
        f'<ul class="legend">{legend}</ul></figure>'
    )


def strips(bindings: Sequence[Binding], end: float) -> str:
    """Return when each limit binds, a strip each, in SVG.

    Args:
        bindings: The limits.
        end: When the motion ends [s].
    """
    height = TOP + STRIP * len(bindings) + BOTTOM
    left, right = NAMES, WIDTH - RIGHT

    def x(time: float) -> float:
        return left + (right - left) * time / end

    rows: list[str] = []
    for number, binding in enumerate(bindings):
        top = TOP + STRIP * number
        rows.append(
            f'<text class="name" x="{left - 8}" y="{top + 14}" text-anchor="end">'
            f"{escape(in_short(binding.name, LONGEST))}</text>"
            f'<rect class="track" x="{left}" y="{top + 4}" width="{right - left}" height="{STRIP - 8}"/>'
        )
        rows += [
            f'<rect class="bound" x="{x(begin):.1f}" y="{top + 4}" '
            f'width="{max(x(stop) - x(begin), 2.0):.1f}" height="{STRIP - 8}">'
            f"<title>{begin:.3f} to {stop:.3f} s</title></rect>"
            for begin, stop in binding.spans
        ]
    return (
        f'<svg class="plot" viewBox="0 0 {WIDTH} {height}" role="img" aria-label="When limits bind" '
        f'data-left="{left}" data-right="{right}" data-end="{end:.9g}">'
        f"{''.join(rows)}{_axis(end, x, height)}{_cursor(height - BOTTOM)}</svg>"
    )


def ticks(lower: float, upper: float) -> list[float]:
    """Return round numbers of a range."""
    rough = (upper - lower) / TICKS
    size = 10.0 ** np.floor(np.log10(rough))
    step = float(size * next(round_ for round_ in (1.0, 2.0, 5.0, 10.0) if round_ * size >= rough))
    first, last = int(np.ceil(lower / step - 1e-9)), int(np.floor(upper / step + 1e-9))
    return [round(number * step, 12) for number in range(first, last + 1)]


def _range(chart: Chart) -> tuple[float, float]:
    values = np.concatenate([line.values for line in chart.lines])
    values = values[np.isfinite(values)]
    if chart.top is not None:
        values = np.append(np.minimum(values, chart.top), chart.top)
    limits = [value for value, _ in chart.limits if chart.top is None or value <= chart.top]
    lowest = min([*limits, *([float(values.min())] if len(values) else [0.0])])
    highest = max([*limits, *([float(values.max())] if len(values) else [1.0])])
    if chart.unit == "m/s":
        lowest = 0.0
    room = 0.06 * max(highest - lowest, 1e-6 * max(abs(highest), 1.0))
    bottom = lowest if chart.unit == "m/s" else lowest - room
    return bottom, (highest if chart.top is not None else highest + room)


def _path(times: Floats, values: Floats, x: Place, y: Place, upper: float) -> str:
    """Return a curve, broken where there is no value, or one that is not drawn."""
    words: list[str] = []
    pen = "M"
    for time, value in zip(times.tolist(), values.tolist(), strict=True):
        if not np.isfinite(value) or value > upper:
            pen = "M"
            continue
        words.append(f"{pen}{x(time):.1f} {y(value):.1f}")
        pen = "L"
    return "".join(words)


def _stroke(number: int) -> str:
    colour = hexadecimal(LINES[number % len(LINES)])
    dashes = DASHES[number // len(LINES) % len(DASHES)]
    return f"stroke:{colour}" + (f";stroke-dasharray:{dashes}" if dashes else "")


def _axis(end: float, x: Place, height: int = HEIGHT) -> str:
    """Return the axis of time."""
    marks = "".join(
        f'<text class="tick" x="{x(tick):.1f}" y="{height - 6}" text-anchor="middle">{tick:g}</text>'
        for tick in ticks(0.0, end)
        if tick < 0.96 * end
    )
    return f'{marks}<text class="tick" x="{x(end):.1f}" y="{height - 6}" text-anchor="end">{end:.3g} s</text>'


def _cursor(bottom: int) -> str:
    return f'<line class="cursor" x1="0" x2="0" y1="{TOP}" y2="{bottom}" visibility="hidden"/>'
