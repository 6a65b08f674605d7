"""The witness: times, and leaves that cover the motion for each pair."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from intervals import Floats
from numpy.typing import NDArray
from reading import demand
from statement import Statement

MOST_CELLS = 60_000
MOST_PLACES = 1_000_000
"""Most joint frames at all times of the grid together."""
MOST_PRODUCTS = 20_000_000
"""Most vertices of the parts of all leaves together."""


@dataclass(frozen=True, eq=False)
class Witness:
    """Evidence that the statement is true.

    Attributes:
        grid: Knots of the motion and times of the witness, increasing, shape (g,) [s].
        pair: Pair of each leaf, shape (l,).
        begin: Index in the grid of each leaf's start, shape (l,), as `end`.
        direction: From the pair's first part to its second, of any length, in the frame of the last joint
            that carries both, shape (l, 3).
    """

    grid: Floats
    pair: NDArray[np.int64]
    begin: NDArray[np.int64]
    end: NDArray[np.int64]
    direction: Floats


def read_witness(data: bytes, statement: Statement) -> Witness:
    """Read a witness.

    The number of times (u4), these (f8), the number of leaves of each pair (u4), the leaves (u2 for the
    start, i2 three times for the direction); all little-endian, with nothing before, between or after.
    """
    count = int(_taken(data, 0, "<u4", 1)[0])
    times = _taken(data, 4, "<f8", count)
    pairs = len(statement.pairs)
    leaves_of = _taken(data, 4 + 8 * count, "<u4", pairs).astype(np.int64)
    head, total = 4 + 8 * count + 4 * pairs, int(leaves_of.sum())
    leaves = _taken(data, head, "<u2", 4 * total).reshape(-1, 4)
    demand(len(data) == head + 8 * total, "the witness is longer than its numbers of times and leaves")
    vertices = np.array([len(getattr(part.shape, "vertices", "")) for part in statement.parts])
    products = int(leaves_of @ [vertices[one] + vertices[other] for one, other, _ in statement.pairs])
    demand(products <= MOST_PRODUCTS, "the witness has too many leaves for the vertices of its parts")
    grid = _grid(times, statement)
    pair = np.repeat(np.arange(pairs), leaves_of)
    begin = leaves[:, 0].astype(np.int64)
    last = np.append(pair[1:] != pair[:-1], True)[: len(pair)]
    end = np.where(last, len(grid) - 1, np.append(begin[1:], 0)[: len(pair)])
    covers = leaves_of.all() and not begin[np.roll(last, 1)].any() and (begin < end).all()
    demand(covers, "the leaves of a pair must begin at the start, increase and reach the end")
    return Witness(grid, pair, begin, end, leaves[:, 1:].view("<i2").astype(np.float64))


def _taken(data: bytes, offset: int, kind: str, count: int) -> NDArray[Any]:
    there = offset + count * np.dtype(kind).itemsize <= len(data)
    demand(there, "the witness is shorter than its numbers of times and leaves")
    return np.frombuffer(data, kind, count, offset)


def _grid(inner: Floats, statement: Statement) -> Floats:
    within = (inner > 0.0) & (inner < statement.motion.times[-1])
    demand(within.all(), "a time of the witness is not within the motion")
    driven = [drive.times[drive.times < statement.motion.times[-1]] for drive in statement.drives]
    grid = np.unique(np.concatenate((statement.motion.times, inner, *driven)))
    few = len(grid) <= MOST_CELLS and len(grid) * (1 + len(statement.joints)) <= MOST_PLACES
    demand(few, "the witness has too many times")
    return grid
