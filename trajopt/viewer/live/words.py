"""The planning result in plain words, as HTML: outcome, cause and prices."""

from collections.abc import Sequence
from html import escape

from trajopt.planning.budget import Stop
from trajopt.planning.result import Result
from trajopt.values.printed import in_length
from trajopt.viewer.live.planning import Planned
from trajopt.viewer.palette import NARROW, SAFE, TOUCHING, Rgb, hexadecimal
from trajopt.why import Price

BLOCK = "margin:0.4em 1em 0.6em 1em;font-size:0.85em;line-height:1.4"
LISTED = 4
"""Number of listed prices and remedies."""


def block_html(title: str, lines: list[str], colour: Rgb | None = None) -> str:
    """Return a heading, if any, in a colour, with lines below it; all of it is text, not HTML."""
    paint = "" if colour is None else f"color:{hexadecimal(colour)};"
    heading = [f'<b style="{paint}">{escape(title)}</b>'] if title else []
    return f'<div style="{BLOCK}">{"<br>".join([*heading, *map(escape, lines)])}</div>'


def planned_html(planned: Planned) -> str:
    """Return how planning ended."""
    result = planned.result
    if result is None:
        return block_html("This cannot be planned", [planned.refusal], TOUCHING)
    if result.verified:
        return _motion(result, planned)
    if result.stopped is Stop.CANCEL:
        return block_html("Planning was cancelled", ["No motion was found until then."], NARROW)
    return _failure(result, planned)


def _motion(result: Result, planned: Planned) -> str:
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


def _failure(result: Result, planned: Planned) -> str:
    explanation, lines = planned.explanation, [f"{_sentence(result.status.value)}."]
    if result.message:
        lines.append(_sentence(result.message))
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
    """Return the binding limits, the most expensive first, with the gain of a change if known."""
    saved = [
        f"• {each.what}: {1000.0 * each.seconds:.0f} ms shorter for each {each.unit} given up"
        for each in sorted(prices, key=lambda each: -(each.seconds or 0.0))
        if each.seconds
    ]
    if saved:
        return ["What would make it shorter:", *saved[:LISTED]]
    return ["Where it is tight:", *(f"• {each.what}" for each in prices[:LISTED])]


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]
