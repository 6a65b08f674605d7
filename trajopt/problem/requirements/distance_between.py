"""Two points of frames at a distance from each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from trajopt.problem.requirements.requirement import MILLIMETRES, Relaxation, Requirement
from trajopt.values.arrays import Floats, floats, number
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.printed import in_length


@dataclass(frozen=True, eq=False)
class DistanceBetween(Requirement):
    """The distance between a point of one frame and a point of another lies between bounds.

    Made by `distance_between`, whose arguments are its fields.
    """

    first: str
    second: str
    lower: float
    upper: float
    first_offset: Floats
    second_offset: Floats

    @property
    def frames(self) -> tuple[str, ...]:
        """Both frames."""
        return (self.first, self.second)

    @property
    def units(self) -> tuple[str, ...]:
        """Metres."""
        return ("m",)

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        """Both bounds, as far as there are any."""
        what, found = f"distance of {self.first} from {self.second}", list[Relaxation]()
        if self.lower > 0.0:
            largest = self.lower
            found.append(
                Relaxation.of(
                    self, "lower", f"smallest {what}", largest=largest, unit=MILLIMETRES, shrinks=True
                )
            )
        if np.isfinite(self.upper):
            found.append(Relaxation.of(self, "upper", f"largest {what}", largest=2.0, unit=MILLIMETRES))
        return tuple(found)

    def __str__(self) -> str:
        """Say the bounds that there are."""
        if np.isinf(self.upper):
            apart = f"at least {in_length(self.lower)}"
        elif self.lower == 0.0:
            apart = f"at most {in_length(self.upper)}"
        else:
            apart = f"{in_length(self.lower)} to {in_length(self.upper)}"
        return f"{self.first} and {self.second} {apart} apart"


@checked
def distance_between(
    first: str,
    second: str,
    *,
    lower: float = 0.0,
    upper: float = np.inf,
    first_offset: ArrayLike = (0.0, 0.0, 0.0),
    second_offset: ArrayLike = (0.0, 0.0, 0.0),
) -> DistanceBetween:
    """Require the distance between two points of frames to lie between bounds.

    Args:
        first: Link, tool frame or object, or "world".
        second: Another; both may move.
        lower: Smallest distance, >= 0 [m].
        upper: Largest distance [m]; inf for none.
        first_offset: The point of the first frame, in its coordinates, shape (3,) [m].
        second_offset: The point of the second frame, in its coordinates, shape (3,) [m].

    Raises:
        ShapeError: If a number is not usable.
        ProblemError: If the bounds are not 0 <= lower < upper, or nothing is bounded.
    """
    low, high = number("lower", lower), number("upper", upper, infinite=True)
    if not 0.0 <= low < high:
        raise ProblemError(f"distance_between: needs 0 <= lower < upper, has {low:g} m and {high:g} m")
    if low == 0.0 and np.isinf(high):
        raise ProblemError(
            f"distance_between({shown(first)}, {shown(second)}): give a lower or an upper bound"
        )
    offsets = (floats("first_offset", first_offset, (3,)), floats("second_offset", second_offset, (3,)))
    return DistanceBetween(first, second, low, high, *offsets)
