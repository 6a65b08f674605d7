"""How lengths, angles, points and axes are printed: short, in millimetres, metres and degrees."""

import numpy as np

from trajopt.arrays import Floats

SMALL = 0.1
"""Lengths below this are printed in millimetres [m]."""


def in_length(metres: float) -> str:
    """Print a length: 12 mm, or 0.25 m."""
    return f"{metres * 1e3:.3g} mm" if abs(metres) < SMALL else f"{metres:.4g} m"


def in_degrees(radians: float) -> str:
    """Print an angle in degrees."""
    return f"{np.rad2deg(radians):.3g} deg"


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
