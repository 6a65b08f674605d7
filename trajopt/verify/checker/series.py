"""Functions of time with their derivatives, as Taylor coefficients that are intervals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from math import factorial
from operator import add, mul

import numpy as np
from intervals import Interval, exactly, sine_and_cosine


@dataclass(frozen=True, eq=False)
class Series:
    """Functions f of time, at times or over cells.

    Attributes:
        terms: f, f', f''/2, f'''/6 and so on. A sum or product has as many as the shorter operand.
    """

    terms: tuple[Interval, ...]

    def __add__(self, other: Series) -> Series:
        return Series(tuple(map(add, self.terms, other.terms)))

    def plus(self, constant: Interval) -> Series:
        return Series((self.terms[0] + constant, *self.terms[1:]))

    def map(self, linear: Callable[[Interval], Interval]) -> Series:
        return Series(tuple(map(linear, self.terms)))

    def along(self, constant: Interval) -> Series:
        """Multiply a constant vector or matrix by numbers (m,)."""
        return self.map(lambda term: term[(..., *[None] * constant.low.ndim)] * constant)

    def times(self, bilinear: Callable[[Interval, Interval], Interval], other: Series) -> Series:
        """Apply a bilinear operation, such as a cross product, by the product rule (Leibniz)."""
        orders = range(min(len(self.terms), len(other.terms)))
        one, two = self.terms, other.terms
        products = ([bilinear(one[at], two[order - at]) for at in range(order + 1)] for order in orders)
        return Series(tuple(reduce(add, each) for each in products))

    @property
    def rate(self) -> Series:
        return Series(tuple(term * exactly(float(order)) for order, term in enumerate(self.terms) if order))


def taylor(*derivatives: Interval) -> Series:
    return Series(tuple(each / exactly(float(factorial(order))) for order, each in enumerate(derivatives)))


def constant(value: Interval, terms: int) -> Series:
    return Series((value, *[exactly(np.zeros_like(value.low))] * (terms - 1)))


def sine_and_cosine_of(angle: Series) -> tuple[Series, Series]:
    """Return the sine s and the cosine c of an angle q, by s' = c q' and c' = -s q'."""
    sine, cosine = (Series((each,)) for each in sine_and_cosine(angle.terms[0]))
    for order in range(1, len(angle.terms)):
        s, c = (each.times(mul, angle.rate).terms[-1] / exactly(float(order)) for each in (sine, cosine))
        sine, cosine = Series((*sine.terms, c)), Series((*cosine.terms, -s))
    return sine, cosine
