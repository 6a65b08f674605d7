"""Functions of time by their first Taylor coefficients: intervals that hold them at all times of a cell."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from operator import add

from intervals import Floats, Interval, exactly, sine_and_cosine


@dataclass(frozen=True, eq=False)
class Series:
    """Functions f with their derivatives in time.

    Attributes:
        terms: f, f' and f''/2 over cells; f alone at times; a constant has one term, the others are zero.
    """

    terms: tuple[Interval, ...]

    def __add__(self, other: Series) -> Series:
        few, many = sorted((self.terms, other.terms), key=len)
        return Series((*map(add, few, many), *many[len(few) :]))

    def map(self, linear: Callable[[Interval], Interval]) -> Series:
        return Series(tuple(map(linear, self.terms)))

    def times(self, bilinear: Callable[[Interval, Interval], Interval], other: Series) -> Series:
        """Apply a bilinear operation, such as a cross product, by the product rule (Leibniz)."""
        one, two = self.terms, other.terms
        found: list[Interval] = []
        for order in range(max(len(one), len(two))):
            places = range(max(0, order - len(two) + 1), min(order + 1, len(one)))
            found.append(reduce(add, (bilinear(one[place], two[order - place]) for place in places)))
        return Series(tuple(found))


def constant(value: Floats | float) -> Series:
    return Series((exactly(value),))


def over_cells(value: Interval, first: Interval, second: Interval) -> Series:
    """Return functions with bounds of their value, first and second derivative."""
    return Series((value, first, second * exactly(0.5)))


def sine_and_cosine_of(angle: Series) -> tuple[Series, Series]:
    sine, cosine = sine_and_cosine(angle.terms[0])
    if len(angle.terms) == 1:
        return Series((sine,)), Series((cosine,))
    _, rate, bend = angle.terms
    half = rate * rate * exactly(0.5)
    return (
        Series((sine, cosine * rate, cosine * bend - sine * half)),
        Series((cosine, -(sine * rate), -(sine * bend + cosine * half))),
    )
