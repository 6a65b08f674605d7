"""The report of a campaign: as lines of text, and as one HTML page that needs nothing beside itself."""

from collections.abc import Sequence
from html import escape

import numpy as np

from trajopt.lab.campaign.comparison import Change, Comparison
from trajopt.lab.campaign.statistics import Estimate
from trajopt.lab.campaign.summary import Group, PlaceMap, Summary
from trajopt.lab.campaign.svg import distribution, heat_map, shares
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


def lines(found: Summary, beside: Comparison | None = None) -> list[str]:
    """Return a report as aligned lines.

    Args:
        found: What came of a campaign.
        beside: How it differs from another.
    """
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


def page(found: Summary, beside: Comparison | None = None) -> str:
    """Return a report as a page.

    Args:
        found: What came of a campaign.
        beside: How it differs from another.
    """
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
    """Return the map of the places of a base as SVG: the share of all tasks and turns that is verified."""
    shown: Floats = np.where(places.rows > 0, places.verified / np.maximum(places.rows, 1), np.nan)
    return heat_map(places.x, places.y, shown, places.best[:2])


def place_sentence(places: PlaceMap) -> str:
    """Say where the base does best."""
    x, y, yaw, held = places.best
    return f"the base does best at x {x:g} m, y {y:g} m, turned by {yaw:g} rad: {held:.1%} verified there"


def comparison_sentences(found: Comparison) -> list[str]:
    """Say what differs between two campaigns."""
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


def _changes(title: str, changes: Sequence[Change]) -> str:
    if not changes:
        return ""
    rows = [[escape(cell) for cell in (each.id, each.family, each.before, each.after)] for each in changes]
    head = ("row", "set", "then", "now")
    return f"<h3>{title}: {len(changes)}</h3>{table(head, rows[:MOST_CHANGES])}"


def _groups(found: Summary) -> list[Group]:
    """Return all groups that say more than the whole."""
    parts = [each for each in (found.by_robot, found.by_family, found.by_options) if len(each) > 1]
    return [found.whole, *(each for part in parts for each in part)]


def _cells(each: Group) -> tuple[str, ...]:
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
