"""The report of a campaign, as text or as a self-contained HTML page."""

from collections.abc import Sequence
from html import escape
from math import ceil, floor, log10

import numpy as np

from trajopt.lab.campaign.summary import CampaignSummary, Comparison, Estimate, PlaceMap, RowChange, RowGroup
from trajopt.lab.suite.html import document, table
from trajopt.values.arrays import Floats
from trajopt.values.printed import aligned

HEAD = ("", "rows", "verified", "success", "CPU ms median", "CPU ms p90", "motion s", "clearance mm")
NUMBERS = HEAD[1:]
MOST_CHANGES = 200
"""Changed problems that a page lists; `--json` has all."""
STYLE = "figure { margin: 0 0 1rem; overflow-x: auto; } td { font-variant-numeric: tabular-nums; }"
LEGEND = (
    "Intervals at 95 %: of shares Wilson's, of medians and ninetieth percentiles two of the values "
    "themselves (order statistics). CPU: process time of one problem, all included. Clearance: the smallest "
    "that was proven."
)


def lines(found: CampaignSummary, beside: Comparison | None = None) -> list[str]:
    """Return a report as aligned lines."""
    rows = [HEAD, *(_cells(each) for each in _groups(found))]
    told = [
        f"{found.name}: {found.whole.rows} of {found.total} rows",
        *aligned(rows, right=frozenset(range(1, 8))),
    ]
    told += [f"  {count:6} x {cause}" for cause, count in found.causes.items()]
    if found.places is not None:
        told.append(place_sentence(found.places))
    if beside is not None:
        told += ["", *comparison_sentences(beside)]
    return told


def page(found: CampaignSummary, beside: Comparison | None = None) -> str:
    """Return a report as a page."""
    rows = [[escape(cell) for cell in _cells(each)] for each in _groups(found)]
    by = found.by_family if len(found.by_family) > 1 else found.by_robot
    bars = shares(
        [each.name for each in by], [(each.success.value, each.success.low, each.success.high) for each in by]
    )
    body = [
        f"<p>{found.whole.rows} of {found.total} rows.</p>{table(HEAD, rows, numbers=NUMBERS)}",
        f'<p class="faint">{escape(LEGEND)}</p><h2>Success</h2><figure>{bars}</figure>',
    ]
    if len(found.times) and found.times[0] > 0.0:
        curve = distribution(found.times, "process time of one problem [s]")
        body.append(f"<h2>Time</h2><figure>{curve}</figure>")
    if found.places is not None:
        body.append(
            f"<h2>Places of the base</h2><p>{escape(place_sentence(found.places))}</p>"
            f"<figure>{map_of(found.places)}</figure>"
        )
    if found.causes:
        causes = [(escape(cause), str(count)) for cause, count in found.causes.items()]
        body.append(f"<h2>Why not</h2>{table(('cause', 'rows'), causes, numbers=('rows',))}")
    if beside is not None:
        body.append(_comparison(beside))
    return document(f"Campaign: {found.name}", STYLE, "".join(body))


def map_of(places: PlaceMap) -> str:
    """Return the map of the places of a base as SVG: the share of all tasks and turns verified."""
    shown: Floats = np.where(places.rows > 0, places.verified / np.maximum(places.rows, 1), np.nan)
    return heat_map(places.x, places.y, shown, places.best[:2])


def place_sentence(places: PlaceMap) -> str:
    x, y, yaw, held = places.best
    return f"the base does best at x {x:g} m, y {y:g} m, turned by {yaw:g} rad: {held:.1%} verified there"


def comparison_sentences(found: Comparison) -> list[str]:
    """Describe the differences of two campaigns."""
    before, after = found.verified
    said = [
        f"{found.common} problems in common with {found.first}: verified {before} there, {after} here; "
        f"{len(found.gained)} gained, {len(found.lost)} lost ({_chance(found.chance)}, McNemar's exact test)"
    ]
    if found.cpu_ratio is not None:
        said.append(
            f"process time: {_times(found.cpu_ratio)} that of {found.first}; less on {found.faster[0]}, "
            f"more on {found.faster[1]} ({_chance(found.speed_chance)}, exact sign test)"
        )
    if found.duration_ratio is not None:
        said.append(f"duration of the motions: {_times(found.duration_ratio)}")
    said += [
        f"  lost {each.id[:12]} {each.family}: {each.before}, now {each.after}" for each in found.lost[:20]
    ]
    return said


def _comparison(found: Comparison) -> str:
    said = "".join(f"<p>{escape(text)}</p>" for text in comparison_sentences(found) if text[:2] != "  ")
    changes = _changes("Lost", found.lost) + _changes("Gained", found.gained)
    return f"<h2>Beside {escape(found.first)}</h2>{said}{changes}"


def _changes(title: str, changes: Sequence[RowChange]) -> str:
    if not changes:
        return ""
    rows = [[escape(cell) for cell in (each.id, each.family, each.before, each.after)] for each in changes]
    head = ("row", "set", "then", "now")
    return f"<h3>{title}: {len(changes)}</h3>{table(head, rows[:MOST_CHANGES])}"


def _groups(found: CampaignSummary) -> list[RowGroup]:
    parts = [each for each in (found.by_robot, found.by_family, found.by_options) if len(each) > 1]
    return [found.whole, *(each for part in parts for each in part)]


def _cells(each: RowGroup) -> tuple[str, ...]:
    return (
        each.name,
        str(each.rows),
        str(each.verified),
        _estimate(each.success, 100.0, ".1f", " %"),
        _estimate(each.cpu_median, 1e3, ".1f"),
        _estimate(each.cpu_p90, 1e3, ".1f"),
        "" if each.duration is None else f"{each.duration:.3f}",
        "" if each.clearance is None else f"{1e3 * each.clearance:.2f}",
    )


def _estimate(value: Estimate | None, factor: float, form: str, unit: str = "") -> str:
    if value is None:
        return ""
    low, high = format(factor * value.low, form), format(factor * value.high, form)
    return f"{format(factor * value.value, form)}{unit} ({low} to {high})"


def _times(value: Estimate) -> str:
    return f"{value.value:.3f} times ({value.low:.3f} to {value.high:.3f})"


def _chance(value: float) -> str:
    return f"p = {value:.2g}"


WIDTH, HEIGHT = 640, 300
LEFT, RIGHT, TOP, BOTTOM = 60, 16, 14, 42
"""Room for the axes' numbers and names [px]."""
CELL = 26
MAP_AXES = "x of the base [m], y upward [m]; white: nothing is verified, dark: all"
MOST_POINTS = 400


def distribution(times: Floats, name: str) -> str:
    """Draw the cumulative distribution of ascending positive values, over a logarithmic axis."""
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
    """Draw shares as bars with their intervals, each in [0, 1]."""
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
    """Draw shares (b, a) over x (a,) and y (b,) [m], white for none, dark for all; mark a place."""
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
