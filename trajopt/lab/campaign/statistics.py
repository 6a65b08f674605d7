"""What a count or a sample says of all problems like these: intervals at 95 %, and whether two differ."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from trajopt.values.arrays import Floats

LEVEL = 0.95
"""Confidence of every interval."""
NORMAL = 1.959963984540054
"""Quantile of the normal distribution for it."""


@dataclass(frozen=True)
class Estimate:
    """A number, and where it may be as far as the sample tells.

    Attributes:
        value: The number.
        low: Lower end of its interval at 95 %.
        high: Upper end.
    """

    value: float
    low: float
    high: float


def share(count: int, total: int) -> Estimate:
    """Return a share with its interval.

    Source: Wilson, Probable inference, the law of succession, and statistical inference, 1927.

    Args:
        count: How many did.
        total: Of how many, at least 1.
    """
    part, square = count / total, NORMAL**2
    middle = (part + square / (2.0 * total)) / (1.0 + square / total)
    half = NORMAL / (1.0 + square / total) * sqrt(part * (1.0 - part) / total + square / (4.0 * total**2))
    return Estimate(part, max(0.0, min(part, middle - half)), min(1.0, max(part, middle + half)))


def quantile(values: Sequence[float] | Floats, level: float) -> Estimate:
    """Return a quantile with its interval, whatever the distribution: two of the values themselves.

    How many of n values lie below the quantile is binomial. Of fewer values than it takes for an interval
    at 95 % the ends are the least and the largest.

    Source: David and Nagaraja, Order Statistics, 2003, section 7.1.

    Args:
        values: The values, at least one.
        level: Which quantile, in (0, 1).
    """
    from scipy.stats import binom

    ordered = np.sort(np.asarray(values, dtype=np.float64))
    count = len(ordered)
    outside = (1.0 - LEVEL) / 2.0
    low = int(binom.ppf(outside, count, level)) - 1
    high = int(binom.ppf(1.0 - outside, count, level))
    middle = float(np.quantile(ordered, level))
    ends = (float(ordered[max(0, low)]), float(ordered[min(count - 1, high)]))
    return Estimate(middle, min(middle, ends[0]), max(middle, ends[1]))


def changed_by_chance(gained: int, lost: int) -> float:
    """Return how likely it is that at least so uneven a change of the same problems is chance.

    The exact test of McNemar: were there no difference, each of the changes would be a fair coin's.

    Args:
        gained: Problems solved in the second run only.
        lost: Problems solved in the first run only.
    """
    from scipy.stats import binomtest

    changes = gained + lost
    return float(binomtest(gained, changes, 0.5).pvalue) if changes else 1.0
