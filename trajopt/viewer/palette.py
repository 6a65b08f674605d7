"""Colours: one calm palette for page and plots, distinct for colour-blind readers too.

Source: Paul Tol, "Colour Schemes", SRON technical note 09-002, 2021 ("bright" and "light").
"""

from typing import TypeAlias

Rgb: TypeAlias = tuple[int, int, int]

LINES: tuple[Rgb, ...] = (
    (0x44, 0x77, 0xAA),
    (0xEE, 0x66, 0x77),
    (0x22, 0x88, 0x33),
    (0xCC, 0xBB, 0x44),
    (0x66, 0xCC, 0xEE),
    (0xAA, 0x33, 0x77),
    (0x77, 0x77, 0x77),
)
"""For curves, in this order."""

SURFACES: tuple[Rgb, ...] = (
    (0x77, 0xAA, 0xDD),
    (0xEE, 0xDD, 0x88),
    (0x44, 0xBB, 0x99),
    (0xEE, 0x88, 0x66),
    (0x99, 0xDD, 0xFF),
    (0xBB, 0xCC, 0x33),
    (0xFF, 0xAA, 0xBB),
    (0xAA, 0xAA, 0x00),
)
"""For objects, in this order."""

LINKS: tuple[Rgb, ...] = ((0xE6, 0xE6, 0xE3), (0xC4, 0xC8, 0xCE))
"""For links whose description states no colour, in turn."""

COLLISION: Rgb = (0xEE, 0x88, 0x66)
"""For the robot's collision shapes, drawn over its links."""

GROUND: Rgb = (0xE4, 0xE4, 0xE0)
"""For half-spaces."""

SAFE: Rgb = (0x1B, 0x5E, 0x7A)
NARROW: Rgb = (0xB0, 0x6A, 0x00)
TOUCHING: Rgb = (0xB0, 0x1C, 0x2E)
"""For a clearance above its margin, below it, and none."""

TOOL_PATH: Rgb = (0xAA, 0x33, 0x77)
"""For the path of the tool."""

STOP: Rgb = (0xE0, 0x8A, 0x00)
"""Colour of the robot at its stop."""


def hexadecimal(colour: Rgb) -> str:
    """Return a colour as "#rrggbb"."""
    return "#{:02x}{:02x}{:02x}".format(*colour)
