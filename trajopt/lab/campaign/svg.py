"""Plots as SVG, drawn by hand: a page that holds them needs nothing beside itself."""

from collections.abc import Sequence
from html import escape
from math import ceil, floor, log10

import numpy as np

from trajopt.values.arrays import Floats

WIDTH, HEIGHT = 640, 300
LEFT, RIGHT, TOP, BOTTOM = 60, 16, 14, 42
"""Room for the axes' numbers and names [px]."""
CELL = 26
"""Of a map [px]."""
MAP_AXES = "x of the base [m], y upward [m]; white: nothing is verified, dark: all"
MOST_POINTS = 400
"""Of a curve: more are not seen."""


def distribution(times: Floats, name: str) -> str:
    """Return how many of the values are at most so large, over a logarithmic axis.

    Args:
        times: Values, ascending, positive.
        name: What they are, with the unit.
    """
    low, high = floor(log10(times[0])), ceil(log10(times[-1]))
    high = max(high, low + 1)
    wide, tall = WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM

    def at(value: float, part: float) -> tuple[float, float]:
        return LEFT + wide * (log10(value) - low) / (high - low), TOP + tall * (1.0 - part)

    chosen = np.unique(np.linspace(0, len(times) - 1, min(len(times), MOST_POINTS)).astype(int))
    points = [at(float(times[i]), (i + 1) / len(times)) for i in chosen]
    parts = [_text(LEFT + wide / 2, HEIGHT - 6, name, "middle")]
    for power in range(low, high + 1):
        x, y = at(10.0**power, 0.0)
        parts += [_line(x, TOP, x, y), _text(x, y + 16, f"{10.0**power:g}", "middle")]
    for part in (0.0, 0.25, 0.5, 0.75, 1.0):
        _, y = at(10.0**low, part)
        parts += [_line(LEFT, y, LEFT + wide, y), _text(LEFT - 6, y + 4, f"{part:.0%}", "end")]
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    parts.append(f'<polyline points="{path}" fill="none" stroke="#1a7f37" stroke-width="2"/>')
    return _drawing(WIDTH, HEIGHT, parts)


def shares(names: Sequence[str], values: Sequence[tuple[float, float, float]]) -> str:
    """Return shares as bars with their intervals.

    Args:
        names: What each is of.
        values: Share and the ends of its interval, each in [0, 1].
    """
    row, left = 24, 200
    wide, tall = WIDTH - left - RIGHT, TOP + row * len(names) + 24
    parts: list[str] = []
    for part in (0.0, 0.25, 0.5, 0.75, 1.0):
        x = left + wide * part
        parts += [_line(x, TOP, x, tall - 22), _text(x, tall - 6, f"{part:.0%}", "middle")]
    for place, (name, (value, low, high)) in enumerate(zip(names, values, strict=True)):
        y = TOP + row * place
        label = name if len(name) <= 28 else f"{name[:27]}…"
        parts.append(_text(left - 6, y + 16, label, "end"))
        size = f'width="{wide * value:.1f}" height="16"'
        parts.append(f'<rect x="{left}" y="{y + 4}" {size} fill="#1a7f37" opacity=".6"/>')
        parts.append(_line(left + wide * low, y + 12, left + wide * high, y + 12, "currentColor", 2))
    return _drawing(WIDTH, tall, parts)


def heat_map(x: Floats, y: Floats, values: Floats, mark: tuple[float, float] | None = None) -> str:
    """Return a map of shares, white for none and dark for all; x to the right, y upward.

    Args:
        x: Places along x, shape (a,) [m].
        y: Places along y, shape (b,) [m].
        values: Shares in [0, 1], shape (b, a); nan where there is none.
        mark: A place to mark [m].
    """
    rows, columns = values.shape
    parts: list[str] = []
    for i in range(rows):
        for j in range(columns):
            value = float(values[i, j])
            if np.isnan(value):
                continue
            left, top = LEFT + CELL * j, TOP + CELL * (rows - 1 - i)
            shade = ",".join(str(round(255 + (end - 255) * value)) for end in (8, 81, 156))
            parts.append(
                f'<rect x="{left}" y="{top}" width="{CELL}" height="{CELL}" fill="rgb({shade})">'
                f"<title>x {x[j]:g} m, y {y[i]:g} m: {value:.0%}</title></rect>"
            )
            if mark is not None and mark == (float(x[j]), float(y[i])):
                centre = f'cx="{left + CELL / 2}" cy="{top + CELL / 2}"'
                parts.append(f'<circle {centre} r="6" fill="none" stroke="#cf222e" stroke-width="3"/>')
    below, right = TOP + CELL * rows, LEFT + CELL * columns
    for ends in ((LEFT, TOP, right, TOP), (LEFT, below, right, below)):
        parts.append(_line(*ends))
    for across in (LEFT, right):
        parts.append(_line(across, TOP, across, below))
    for j in range(0, columns, max(1, columns // 6)):
        parts.append(_text(LEFT + CELL * (j + 0.5), below + 16, f"{x[j]:.3g}", "middle"))
    for i in range(0, rows, max(1, rows // 6)):
        parts.append(_text(LEFT - 6, TOP + CELL * (rows - 1 - i + 0.5) + 4, f"{y[i]:.3g}", "end"))
    parts.append(_text((LEFT + right) / 2, below + 34, MAP_AXES, "middle"))
    return _drawing(right + RIGHT, below + 42, parts)


def _drawing(width: float, height: float, parts: Sequence[str]) -> str:
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" width="{width:g}" '
        f'height="{height:g}" font-family="system-ui, sans-serif" font-size="12">{"".join(parts)}</svg>'
    )


def _text(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="currentColor">{escape(text)}</text>'


def _line(x: float, y: float, to_x: float, to_y: float, colour: str = "#8884", width: float = 1) -> str:
    ends = f'x1="{x:.1f}" y1="{y:.1f}" x2="{to_x:.1f}" y2="{to_y:.1f}"'
    return f'<line {ends} stroke="{colour}" stroke-width="{width:g}"/>'
