"""Required clearance: how far apart things must stay, unlike the margin, which is only aimed at."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from trajopt.arrays import number
from trajopt.errors import ShapeError

ROOM = 5e-3
"""The optimiser aims at this much more than is required: samples, tolerances and timing take a part [m]."""

PAIRS_DIFFER = " (single pairs differ)"
"""Added to a clearance that is not the same for all pairs."""


def how_near(first: str, second: str, distance: float, required: float) -> str:
    """Say that two things are inside each other, or nearer than is required [m]."""
    if distance <= 0.0:
        depth = -distance * 1000
        return f"{first} is {depth:.1f} mm inside {second}" if depth >= 0.05 else f"{first} touches {second}"
    return f"{first} is {distance * 1000:.1f} mm from {second}, {required * 1000:g} mm are required"


@dataclass(frozen=True)
class Clearances:
    """The clearance that is required between links and objects; none by default.

    Attributes:
        everywhere: Between any two [m].
        pairs: Between single pairs, where it differs [m].
        links: Between a link, with what it carries, and what stands in the world, where it is more [m].
    """

    everywhere: float = 0.0
    pairs: Mapping[frozenset[str], float] = field(default_factory=dict[frozenset[str], float])
    links: Mapping[str, float] = field(default_factory=dict[str, float])

    def __post_init__(self) -> None:
        """Refuse negative clearances."""
        for value in (self.everywhere, *self.pairs.values(), *self.links.values()):
            if number("required clearance", value) < 0.0:
                raise ShapeError("required clearance", f"is negative: {value:g} m")

    def having(self, value: float, pair: frozenset[str] | None) -> "Clearances":
        """Return these with another clearance everywhere, or between two things [m].

        Raises:
            ShapeError: If it is negative or not finite.
        """
        if pair is None:
            return replace(self, everywhere=value)
        return replace(self, pairs={**self.pairs, pair: value})

    def without(self, name: str) -> "Clearances":
        """Return these without those of single pairs with a name."""
        return replace(self, pairs={pair: value for pair, value in self.pairs.items() if name not in pair})

    def beside(self, margin: float, pair_margins: Mapping[frozenset[str], float]) -> str:
        """Say what is required everywhere, and the margin [m] beside it; and whether pairs differ."""
        clearance = f"clearance {1000 * self.everywhere:g} mm required" + PAIRS_DIFFER * bool(
            self.pairs or self.links
        )
        return f"{clearance}, margin {1000 * margin:g} mm" + PAIRS_DIFFER * bool(pair_margins)
