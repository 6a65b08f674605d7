"""The base of every requirement, and what several of them need."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from trajopt.arrays import Floats, Value, floats, number, readonly
from trajopt.errors import ProblemError, ShapeError

WORLD = "world"
"""Name of the frame that everything is placed in at last."""


@dataclass(frozen=True)
class Requirement(Value):
    """Base of everything that a motion can be asked to hold."""

    @property
    def frames(self) -> tuple[str, ...]:
        """The frames and objects it names, so that a problem can refuse unknown ones."""
        return ()

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints it names."""
        return ()


def direction_of(name: str, value: ArrayLike) -> Floats:
    """Return a vector scaled to length one, shape (3,).

    Raises:
        ShapeError: If it has no length or is no vector.
    """
    vector = floats(name, value, (3,))
    length = float(np.linalg.norm(vector))
    if length < 1e-9:
        raise ShapeError(name, "has no length, so it is no direction")
    return readonly(vector / length)


def positive(name: str, value: float, *, infinite: bool = False) -> float:
    """Return a number that must be positive.

    Raises:
        ShapeError: If it is no number.
        ProblemError: If it is not positive.
    """
    checked = number(name, value, infinite=infinite)
    if checked <= 0.0:
        raise ProblemError(f"{name} must be positive, is {checked:g}")
    return checked
