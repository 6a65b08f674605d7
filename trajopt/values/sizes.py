"""Lengths that a shape may have, in metres."""

from trajopt.values.arrays import number
from trajopt.values.errors import SizeError

LARGEST_SIZE = 50.0
"""Sizes beyond this [m] are taken for millimetres and refused; planes have none."""


def length(name: str, value: float) -> float:
    """Return a length of a shape [m].

    Raises:
        SizeError: If it is not positive, or larger than any shape may be.
    """
    checked = number(name, value)
    if checked <= 0.0:
        raise SizeError(name, f"must be positive, is {checked:g} m")
    if checked > LARGEST_SIZE:
        raise SizeError(name, f"is {checked:g} m; lengths are in metres: was {checked / 1000:g} m meant?")
    return checked
