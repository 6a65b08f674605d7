"""Texts of the pages, as HTML: clearance, joints, events and planning results."""

from collections.abc import Sequence
from html import escape

import numpy as np

from trajopt.driving.events import Event
from trajopt.planning.budget import Stop
from trajopt.planning.result import Result
from trajopt.robot.joints import JointLimits
from trajopt.tasks.sequence import StageRow
from trajopt.values.arrays import Floats
from trajopt.values.printed import capital, in_length
from trajopt.viewer.clearance import Nearest
from trajopt.viewer.live.background import PlanningOutcome
from trajopt.viewer.palette import NARROW, SAFE, TOUCHING, Rgb, hexadecimal
from trajopt.why import Price

_BLOCK = "margin:0.4em 1em 0.6em 1em;font-size:0.85em;font-variant-numeric:tabular-nums;line-height:1.35"


def clearance_html(nearest: Nearest | None) -> str:
    """Return the clearance, its verdict and the names of the pair."""
    if nearest is None:
        return f'<div style="{_BLOCK}"><b>Clearance</b><br>nothing here can touch anything</div>'
    if nearest.distance <= 0.0:
        colour, verdict = TOUCHING, "contact"
    elif nearest.distance < nearest.required:
        colour, verdict = TOUCHING, f"below the required {nearest.required * 1000:g} mm"
    elif nearest.distance < nearest.margin:
        colour, verdict = NARROW, f"below the margin of {nearest.margin * 1000:g} mm"
    else:
        colour, verdict = SAFE, f"margin {nearest.margin * 1000:g} mm"
    if nearest.required > 0.0 and colour != TOUCHING:
        verdict += f", required {nearest.required * 1000:g} mm"
    if nearest.error > 0.0:
        verdict += f"; {decimal(nearest.error * 1000)} mm taken off, for it may be off its track"
    first, second = (escape(name) for name in nearest.owners)
    return (
        f'<div style="{_BLOCK}"><b>Clearance</b> '
        f'<span style="color:{hexadecimal(colour)};font-weight:600">{decimal(nearest.distance * 1000)} mm'
        f"</span> ({verdict})<br>{first} &ndash; {second}</div>"
    )


def joints_html(limits: JointLimits, positions: Floats, revolute: tuple[bool, ...]) -> str:
    """Return a table of the joints: name, place in its range, value in degrees or millimetres."""
    rows: list[str] = []
    for joint, name in enumerate(limits.joint_names):
        value, unit = (
            (np.degrees(positions[joint]), "&deg;") if revolute[joint] else (positions[joint] * 1000, " mm")
        )
        rows.append(
            f'<tr><td style="padding-right:0.8em">{escape(name)}</td>'
            f'<td style="width:38%">{_range_bar(limits, joint, float(positions[joint]))}</td>'
            f'<td style="text-align:right;padding-left:0.8em">{decimal(float(value))}{unit}</td></tr>'
        )
    return (
        f'<div style="{_BLOCK}"><b>Joints</b>'
        f'<table style="width:100%;border-collapse:collapse">{"".join(rows)}</table></div>'
    )


_NUMBER = "text-align:right;vertical-align:top;padding-left:0.8em;white-space:nowrap"
STAGES = 18
"""Number of listed lines of the tree, around the present one; the stages that contain them are above."""


def stages_html(rows: Sequence[StageRow], duration: float, now: float) -> str:
    """Return the tree of stages with the rejected ways, the present stage marked."""
    present = max((row.time.begin, k) for k, row in enumerate(rows) if row.time and row.time.begin <= now)[1]
    first = max(min(present - STAGES // 2, len(rows) - STAGES), 0)
    lines: list[str] = []
    above = [k for k in range(first) if all(rows[k].depth < row.depth for row in rows[k + 1 : first + 1])]
    for k in [*above, *range(first, min(first + STAGES, len(rows)))]:
        row = rows[k]
        marked = f"color:{hexadecimal(SAFE)};font-weight:600" if k == present else ""
        clear = f"{in_length(row.clearance)} clear" if np.isfinite(row.clearance) else ""
        spent = [] if row.time is None else [f"{row.time.end - row.time.begin:.2f} s", clear]
        cells = "".join(f'<td style="{_NUMBER}">{words}</td>' for words in spent)
        lines.append(
            f'<tr style="{marked}"><td style="padding-left:{row.depth + 1}em;text-indent:-1em" '
            f'colspan="{1 if spent else 3}">{escape(row.text)}</td>{cells}</tr>'
        )
    table = f'<table style="border-collapse:collapse">{"".join(lines)}</table>'
    return f'<div style="{_BLOCK}"><b>Stages</b>, {duration:.2f} s{table}</div>'


def events_html(events: Sequence[Event], shown: int) -> str:
    rows = [
        f'<tr><td style="text-align:right;padding-right:0.8em;vertical-align:top">{event.time:.2f} s</td>'
        f"<td><b>{escape(event.kind.value)}</b>{escape(event.message and f': {event.message}')}</td></tr>"
        for event in reversed(events[-shown:])
    ]
    more = f"<br>and {len(events) - shown} before" if len(events) > shown else ""
    table = f'<table style="border-collapse:collapse">{"".join(rows)}</table>' if rows else "<br>none yet"
    return f'<div style="{_BLOCK}"><b>Events</b>{table}{more}</div>'


def decimal(value: float) -> str:
    return f"{round(value, 1) + 0.0:.1f}"


def _range_bar(limits: JointLimits, joint: int, position: float) -> str:
    lower, upper = float(limits.lower[joint]), float(limits.upper[joint])
    if not (np.isfinite(lower) and np.isfinite(upper) and upper > lower):
        return ""
    share = 100.0 * min(max((position - lower) / (upper - lower), 0.0), 1.0)
    return (
        '<div style="position:relative;height:0.3em;border-radius:0.15em;background:#dfe3e8">'
        f'<div style="position:absolute;left:calc({share:.1f}% - 0.2em);top:-0.15em;width:0.4em;'
        f'height:0.6em;border-radius:0.2em;background:{hexadecimal(SAFE)}"></div></div>'
    )


BLOCK = "margin:0.4em 1em 0.6em 1em;font-size:0.85em;line-height:1.4"
LISTED = 4
"""Number of listed prices and remedies."""


def block_html(title: str, lines: list[str], colour: Rgb | None = None) -> str:
    """Return a heading, if any, in a colour, with lines below it; all of it is text, not HTML."""
    paint = "" if colour is None else f"color:{hexadecimal(colour)};"
    heading = [f'<b style="{paint}">{escape(title)}</b>'] if title else []
    return f'<div style="{BLOCK}">{"<br>".join([*heading, *map(escape, lines)])}</div>'


def planned_html(planned: PlanningOutcome) -> str:
    result = planned.result
    if result is None:
        return block_html("This cannot be planned", [planned.refusal], TOUCHING)
    if result.verified:
        return _motion(result, planned)
    if result.stopped is Stop.CANCEL:
        return block_html("Planning was cancelled", ["No motion was found until then."], NARROW)
    return _failure(result, planned)


def _motion(result: Result, planned: PlanningOutcome) -> str:
    certificate, lines = result.certificate, list[str]()
    if certificate is not None and certificate.closest:
        lines.append(f"Free of collisions: {certificate.closest}.")
    lines.append("All joints keep their limits of position, velocity and acceleration.")
    if result.stopped is not None:
        lines.append("Cancelled: this is the best motion until then.")
    prices = () if planned.explanation is None else planned.explanation.prices
    if prices:
        lines += _prices(prices)
    return block_html(f"A motion of {result.cost:.2f} s", lines, SAFE)


def _failure(result: Result, planned: PlanningOutcome) -> str:
    explanation, lines = planned.explanation, [f"{capital(result.status.value)}."]
    if result.message:
        lines.append(capital(result.message))
    if explanation is not None:
        lines += [f"• {block.words}" for block in explanation.blocks[:LISTED]]
        free = explanation.nearest_free
        if free is not None and free.given > 0.0:
            lines.append(f"The nearest place that is free is {in_length(free.given)} off.")
        if explanation.remedies is not None:
            lines.append("Each of these would help:" if explanation.remedies else "No single change helps.")
            lines += [f"• {remedy}" for remedy in explanation.remedies[:LISTED]]
        if explanation.prices:
            lines += _prices(explanation.prices)
    return block_html("No motion was found", lines, TOUCHING)


def _prices(prices: Sequence[Price]) -> list[str]:
    saved = [
        f"• {each.what}: {1000.0 * each.seconds:.0f} ms shorter for each {each.unit} given up"
        for each in sorted(prices, key=lambda each: -(each.seconds or 0.0))
        if each.seconds
    ]
    if saved:
        return ["What would make it shorter:", *saved[:LISTED]]
    return ["Where it is tight:", *(f"• {each.what}" for each in prices[:LISTED])]
