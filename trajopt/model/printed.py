"""How numbers are printed: short, in the units that people use: mm, m, deg, s, Nm."""

from collections.abc import Sequence, Sized

import numpy as np

from trajopt.arrays import Floats

SMALL = 0.1
"""Lengths below this are printed in millimetres [m]."""
PRINTED_UNITS = {"m": ("mm", 1e3), "rad": ("deg", float(np.degrees(1.0)))}
"""What metres and radians are printed in, and how many of it one of them is."""
LONGEST_LINE = 200
"""Characters of what prints in one line."""


def in_length(metres: float) -> str:
    """Print a length: 12 mm, or 0.25 m."""
    return f"{metres * 1e3:.3g} mm" if abs(metres) < SMALL else f"{metres:.4g} m"


def in_degrees(radians: float) -> str:
    """Print an angle in degrees."""
    return f"{np.rad2deg(radians):.3g} deg"


def shown_in(unit: str) -> tuple[str, float]:
    """Return the unit that numbers of a unit are printed in, and what to multiply them by.

    Millimetres for metres and degrees for radians, in speeds and accelerations too; others stay.
    """
    base, per, rest = unit.partition("/")
    name, size = PRINTED_UNITS.get(base, (base, 1.0))
    return name + per + rest, size


def in_unit(value: float, unit: str) -> str:
    """Print a number of a unit: 0.004 m as 4 mm, 0.5 rad/s as 28.65 deg/s, others as they are."""
    if unit == "m":
        return in_length(value)
    name, size = shown_in(unit)
    return f"{value * size + 0.0:.4g} {name}".rstrip()


def in_joint_position(value: float, unit: str) -> str:
    """Print where a joint is: 171.9 deg (3.0000 rad), or 12.5 mm."""
    return in_unit(value, unit) + (f" ({value:.4f} rad)" if unit == "rad" else "")


def in_range(lower: float, upper: float, unit: str) -> str:
    """Print the limits of a joint: [-166, 166] deg."""
    name, size = shown_in(unit)
    return f"[{lower * size + 0.0:.4g}, {upper * size + 0.0:.4g}] {name}".rstrip()


def in_short(text: str, length: int = LONGEST_LINE) -> str:
    """Return the first line of a text, cut to a length."""
    line, _, more = text.partition("\n")
    return f"{line[: length - 3]}..." if len(line) > length or (more and len(line) > length - 3) else line


def in_number(items: Sized, one: str, several: str = "") -> str:
    """Print how many there are: 1 joint, 7 joints."""
    return f"{len(items)} {one if len(items) == 1 else several or one + 's'}"


def in_radians(angle: float) -> str:
    """Print an angle that was given wrong, and what it would be had it been meant in degrees."""
    meant = f" rad: were degrees meant? {angle:g} deg are {np.deg2rad(angle):.4g} rad"
    return f"{angle:g}{meant if abs(angle) > np.pi else ' rad'}"


def in_point(xyz: Floats) -> str:
    """Print a point in metres, to a tenth of a millimetre."""
    return f"({_numbers(xyz)}) m"


def in_axis(direction: Floats) -> str:
    """Print a unit vector: the name of the axis that it is, or its coordinates."""
    for index, name in enumerate("xyz"):
        if abs(float(direction[index])) > 1.0 - 1e-9:
            return name if direction[index] > 0.0 else f"-{name}"
    return f"({_numbers(direction)})"


def seen_from(reference: str) -> str:
    """Name the frame that coordinates are relative to, unless it is the world."""
    return "" if reference == "world" else f" from {reference}"


def _numbers(values: Floats) -> str:
    return ", ".join(f"{value + 0.0:.4g}" for value in np.asarray(values).round(4).tolist())


def aligned(rows: Sequence[Sequence[str]], *, right: frozenset[int]) -> list[str]:
    """Pad the cells of each column to one width.

    Args:
        rows: Rows of equal length.
        right: Columns that are flush right.

    Returns:
        One line a row, without trailing blanks.
    """
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return [
        "  ".join(
            cell.rjust(width) if column in right else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]
