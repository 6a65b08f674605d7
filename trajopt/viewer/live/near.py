"""The pairs that are told of: the nearest, but of two links of the robot only where they are close."""

from trajopt.values.arrays import Floats
from trajopt.viewer.clearance import ClearanceQuery, Nearest

MEASURED = 24
"""Pairs that are measured to find those with something around the robot among them."""
CLOSE = 0.03
"""Of two links that are no nearer nobody asks the distance: some links are always near each other [m]."""


def telling_pairs(clearance: ClearanceQuery, positions: Floats, count: int) -> tuple[Nearest, ...]:
    """Return the nearest pairs at a posture, the nearest first.

    Args:
        clearance: Measures them.
        positions: Of the group, shape (n,) [rad | m].
        count: How many at most.
    """
    found = clearance.nearest_pairs(0.0, positions, MEASURED)
    objects = clearance.reduced.scene.objects.keys()
    apart = [each for each in found if each.distance < CLOSE or not objects.isdisjoint(each.owners)]
    return tuple((apart or found)[:count])
