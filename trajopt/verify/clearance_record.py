"""What a search for clearance has still to prove, and what it has found."""

from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats, Ints


@dataclass(frozen=True, eq=False)
class Items:
    """What is still to be proven: pairs over intervals.

    Attributes:
        begin: Start of each interval, shape (c,) [s].
        end: End of each, shape (c,) [s].
        cell: Interval of each item, shape (i,).
        pair: Pair of each item, shape (i,).
    """

    begin: Floats
    end: Floats
    cell: Ints
    pair: Ints


@dataclass(frozen=True)
class Contact:
    """A measured contact that is not accepted.

    Attributes:
        pair: The pair.
        time: When [s].
        distance: Signed distance then [m].
    """

    pair: int
    time: float
    distance: float


@dataclass(frozen=True)
class Gap:
    """An interval over which a pair could not be proven to keep apart.

    Attributes:
        pair: The pair.
        begin: Its start [s].
        end: Its end [s].
    """

    pair: int
    begin: float
    end: float


class Tally:
    """Smallest distance proven and measured of every pair.

    Attributes:
        proven: Smallest bound over the intervals proven so far, shape (p,) [m].
        measured: Smallest measured distance, shape (p,) [m]; infinite if never measured.
        time: When it was measured, shape (p,) [s].
    """

    def __init__(self, count: int) -> None:
        """Start with nothing known about a number of pairs."""
        self.proven: Floats = np.full(count, np.inf)
        self.measured: Floats = np.full(count, np.inf)
        self.time: Floats = np.zeros(count)

    def note(self, pair: Ints, distance: Floats, time: Floats) -> None:
        """Take in measured distances."""
        falling = np.argsort(-distance, kind="stable")
        falling = falling[distance[falling] < self.measured[pair[falling]]]
        self.measured[pair[falling]] = distance[falling]
        self.time[pair[falling]] = time[falling]

    def best(self) -> float:
        """Smallest measured distance of all pairs [m]."""
        return float(self.measured.min(initial=np.inf))
