"""Short printed numbers in common units: mm, m, deg, s, Nm."""

from collections.abc import Sequence, Sized

import numpy as np

from trajopt.values.arrays import Floats

SMALL = 0.1
"""Lengths below this are printed in millimetres [m]."""
ROUNDING = 1e-9
"""Lengths and angles below this are rounding errors and print as 0 [m | rad]."""
PRINTED_UNITS = {"m": ("mm", 1e3), "rad": ("deg", float(np.degrees(1.0)))}
"""Unit -> printed unit and factor, for metres and radians."""
LONGEST_LINE = 200
"""Most characters on a printed line."""


def in_length(metres: float) -> str:
    """Print a length: 12 mm, or 0.25 m; rounding errors print as 0 mm."""
    if abs(metres) < ROUNDING:
        return "0 mm"
    return f"{metres * 1e3:.3g} mm" if abs(metres) < SMALL else f"{metres:.4g} m"


def in_degrees(radians: float) -> str:
    """Print an angle in degrees; rounding errors print as 0 deg."""
    if abs(radians) < ROUNDING:
        return "0 deg"
    return f"{np.rad2deg(radians):.3g} deg"


def shown_in(unit: str) -> tuple[str, float]:
    """Return the printed unit of a unit, and the factor.

    Millimetres for metres and degrees for radians, also in speeds and accelerations; other units stay.
    """
    base, per, rest = unit.partition("/")
    name, size = PRINTED_UNITS.get(base, (base, 1.0))
    return name + per + rest, size


def in_unit(value: float, unit: str) -> str:
    """Print a number with its unit: 0.004 m as 4 mm, 0.5 rad/s as 28.65 deg/s."""
    if unit == "m":
        return in_length(value)
    if unit == "rad" and abs(value) < ROUNDING:
        return "0 deg"
    name, size = shown_in(unit)
    return f"{value * size + 0.0:.4g} {name}".rstrip()


def in_unit_apart(value: float, other: float, unit: str) -> tuple[str, str]:
    """Print two numbers of a unit with enough digits to distinguish them: 229.2 deg/s and 229.18 deg/s."""
    name, size = shown_in(unit)
    texts = in_unit(value, unit), in_unit(other, unit)
    for digits in range(5, 18):
        if texts[0] != texts[1] or value == other:
            break
        texts = f"{value * size:.{digits}g} {name}".rstrip(), f"{other * size:.{digits}g} {name}".rstrip()
    return texts


def in_joint_position(value: float, unit: str) -> str:
    """Print a joint position: 171.9 deg (3.0000 rad), or 12.5 mm."""
    return in_unit(value, unit) + (f" ({value:.4f} rad)" if unit == "rad" else "")


def in_range(lower: float, upper: float, unit: str) -> str:
    """Print the limits of a joint: [-166, 166] deg."""
    name, size = shown_in(unit)
    return f"[{lower * size + 0.0:.4g}, {upper * size + 0.0:.4g}] {name}".rstrip()


def in_short(text: str, length: int = LONGEST_LINE) -> str:
    """Return the first line of a text, cut to a length."""
    line, _, more = text.partition("\n")
    return f"{line[: length - 3]}..." if len(line) > length or (more and len(line) > length - 3) else line


def capital(text: str) -> str:
    """Return a text with a capital letter at its beginning."""
    return text[:1].upper() + text[1:]


def in_number(items: Sized, one: str, several: str = "") -> str:
    """Print a count with its noun: 1 joint, 7 joints."""
    return f"{len(items)} {one if len(items) == 1 else several or one + 's'}"


def in_stated_angle(angle: float, *, degrees: bool) -> str:
    """Print an invalid angle [rad]; if it was given in radians, with its value in degrees."""
    if degrees:
        return f"{np.rad2deg(angle):g} deg"
    meant = f" rad: were degrees meant? {angle:g} deg are {np.deg2rad(angle):.4g} rad"
    return f"{angle:g}{meant if abs(angle) > np.pi else ' rad'}"


def in_point(xyz: Floats) -> str:
    """Print a point in metres, to a tenth of a millimetre."""
    return f"({_numbers(xyz)}) m"


def in_axis(direction: Floats) -> str:
    """Print a unit vector: the name of an axis, or its coordinates."""
    for index, name in enumerate("xyz"):
        if abs(float(direction[index])) > 1.0 - 1e-9:
            return name if direction[index] > 0.0 else f"-{name}"
    return f"({_numbers(direction)})"


ON_AXIS = float(np.cos(np.deg2rad(0.5)))
"""Directions within half a degree of an axis print as that axis."""


def in_direction(direction: Floats, reference: str) -> str:
    """Print a unit vector (3,): "up", "along -x", "along (0.5, 0, -0.866), 60 deg down"."""
    coordinates = direction.tolist()
    axis = next((index for index, value in enumerate(coordinates) if abs(value) > ON_AXIS), None)
    if axis is not None:
        if axis == 2 and reference == "world":
            return "up" if coordinates[2] > 0.0 else "down"
        sign = "" if coordinates[axis] > 0.0 else "-"
        return f"along {sign}{'xyz'[axis]}{of_frame(reference)}"
    words = f"along ({', '.join(f'{value + 0.0:.3g}' for value in direction.round(3).tolist())})"
    if reference != "world":
        return words + of_frame(reference)
    tilt = float(np.rad2deg(np.arcsin(np.clip(coordinates[2], -1.0, 1.0))))
    return f"{words}, {abs(tilt):.3g} deg {'up' if tilt > 0.0 else 'down'}" if abs(tilt) >= 0.5 else words


def of_frame(reference: str) -> str:
    return "" if reference == "world" else f" of {reference}"


def seen_from(reference: str) -> str:
    """Name the reference frame of coordinates, unless it is the world."""
    return "" if reference == "world" else f" from {reference}"


def _numbers(values: Floats) -> str:
    return ", ".join(f"{value + 0.0:.4g}" for value in np.asarray(values).round(4).tolist())


def aligned(rows: Sequence[Sequence[str]], *, right: frozenset[int] = frozenset()) -> list[str]:
    """Return rows as lines with columns padded to one width; `right` ones are right-aligned."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return [
        "  ".join(
            cell.rjust(width) if column in right else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]
