"""Tolerances of constraints messages."""

from trajopt.io.document import Node

LEAST_TOLERANCE = 1e-4
"""What a tolerance of zero, or none, means [rad | m]."""


def read_tolerance(node: Node) -> float:
    """Return a tolerance, which may be infinite; zero and missing mean `LEAST_TOLERANCE`.

    Raises:
        FileFormatError: If it is negative or no number.
    """
    value = node.number(0.0, infinite=True)
    if value < 0.0:
        raise node.error(f"is negative: {value:g}")
    return value or LEAST_TOLERANCE
