"""A straight stroke of the tool before an arm: where it lies, and its points."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .arms import Arm
from .drawing import near


@dataclass(frozen=True, eq=False)
class Stroke:
    """Points on a level line across the arm's front.

    Attributes:
        middle: Of the line, in the world, shape (3,) [m].
        along: Its direction, of length one, shape (3,).
        across: The level direction away from the arm, of length one, shape (3,).
        points: First to last, shape (p + 1, 3) [m].
        length: From the first to the last [m].
    """

    middle: NDArray[np.float64]
    along: NDArray[np.float64]
    across: NDArray[np.float64]
    points: NDArray[np.float64]
    length: float


def stroke(
    arm: Arm, rng: np.random.Generator | None, *, length: float, turn: float, height: float, points: int
) -> Stroke:
    """Lay a stroke before an arm.

    Args:
        arm: The arm.
        rng: Draws lengths, turns and heights around those given; exactly those when None.
        length: Of the stroke [m].
        turn: Of the stroke from the arm's left and right, about the vertical [rad].
        height: Above the base [m].
        points: How many, without the first.
    """
    size, angle = near(rng, length, 0.05), near(rng, turn, 0.2)
    along = np.array((-np.sin(angle), np.cos(angle), 0.0))
    middle = np.array((arm.reach - 0.05, near(rng, 0.0, 0.05), near(rng, height, 0.02)))
    places = middle + np.linspace(-0.5, 0.5, points + 1)[:, None] * size * along
    return Stroke(middle, along, np.array((np.cos(angle), np.sin(angle), 0.0)), places, size)
