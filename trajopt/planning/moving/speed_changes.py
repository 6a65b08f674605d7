"""Speed changes: changes of the rate of a motion's clock that hold all limits.

A motion q(c) that holds all limits is run on a clock c(t) whose rate r = dc/dt is between 0 and 1. With a
constant rate all limits hold. From one rate to another it goes by a polynomial that is flat at its
ends, so that the acceleration is continuous,

    r(z) = a + (b - a) (3 z^2 - 2 z^3) + 30 g z^2 (1 - z)^2,    z = t / T,

over m whole cells of the clock and in a time T that is a whole number of ticks: g makes up the difference.
Then, with primes for derivatives by the clock and dots for derivatives of r by time,

    acceleration  q' r. + q'' r^2,
    jerk          q' r.. + 3 q'' r r. + q''' r^3,
    torque        A r. + B r^2 + C,

so a change is possible if these hold, at samples. Rates are such that a cell takes a whole number of
ticks with each: a search over cells and ticks is exact in time.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import ceil

import numpy as np

from trajopt.robot.limits import JointLimits
from trajopt.timing import InverseDynamics
from trajopt.timing.time_scaling import RateChange
from trajopt.values.arrays import Bools, Floats, Ints
from trajopt.values.trajectory import Trajectory

TICKS = 4
"""In a cell, at full rate: the time of a cell is that between two looks, a tick a quarter of it."""
RATES = (0.0, 0.25, 0.5, 0.8, 1.0)
"""Of the clock; TICKS divided by each is whole. More would end a little sooner, and take longer to search."""
FULL = len(RATES) - 1
"""The place of the full rate."""
SPANS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192)
"""Cells that a change may take, later ones at most half as many again: the shortest that holds is taken."""
FINE = 4
"""Slots of a cell: the points of a motion are a few milliseconds apart, a cell twenty."""
EVEN = 9
"""Evenly spaced samples of a change besides those of slots: one that begins at rest stays long in the
first slot.
"""
SIDE = 1e-9
"""Distance of the samples on both sides of a jump of the jerk [s]."""
TOUCH = 1e-9
"""Part of a limit by which a sample may exceed it: rounding."""


@dataclass(frozen=True, eq=False)
class SpeedChange:
    """Change of the rate from one to another, anywhere on the path.

    Attributes:
        before: Place of the first rate.
        after: Place of the last.
        span: Cells of the clock that it takes.
        ticks: Ticks that it takes.
        passed: Ticks at which it enters and leaves each cell, shape (span, 2).
    """

    before: int
    after: int
    span: int
    ticks: int
    passed: Ints

    def at(self, z: Floats, *, cell: float) -> tuple[Floats, Floats, Floats, Floats]:
        """Return the clock since its start, the rate and its first two derivatives by time.

        Args:
            z: Part of its time from 0 to 1, any shape.
            cell: Time of a cell on the clock [s].
        """
        a, b = RATES[self.before], RATES[self.after]
        time = self.ticks * cell / TICKS
        return RateChange(a, b, time, bulge=self.span * cell / time - (a + b) / 2.0).at(z)


@cache
def change(before: int, after: int, span: int) -> SpeedChange:
    """Return the change between two rates over a number of cells."""
    mean = (RATES[before] + RATES[after]) / 2.0
    ticks = ceil(span * TICKS / mean - TOUCH)
    whole = SpeedChange(before, after, span, ticks, np.zeros((span, 2), dtype=np.int64))
    z = np.linspace(0.0, 1.0, 16 * span + 1)
    clock, *_ = whole.at(z, cell=1.0)
    at = np.interp(np.arange(span + 1), clock, z * ticks)
    passed = np.stack((np.floor(at[:-1] + TOUCH), np.ceil(at[1:] - TOUCH)), axis=1).astype(np.int64)
    return SpeedChange(before, after, span, ticks, passed)


@dataclass(frozen=True, eq=False)
class Limited:
    """Shares of the limits used by a motion, by its clock: middle and range of each value in a slot.

    Attributes:
        cells: Number of cells of the clock, of FINE slots each.
        cell: Time of each [s].
        pull: Factors of r. and r^2 in accelerations and torques, and their values at rest, each as part of
            its limit, in the middle, shape (3, slots, j).
        pull_around: Half the range of each.
        jerk: The joints' q', q'' and q''' as parts of their limits of jerk, shape (3, slots, n).
        jerk_around: Half the range of each.
    """

    cells: int
    cell: float
    pull: Floats
    pull_around: Floats
    jerk: Floats
    jerk_around: Floats

    @staticmethod
    def of(
        motion: Trajectory, cells: int, limits: JointLimits, inverse_dynamics: InverseDynamics | None
    ) -> "Limited":
        """Sample a motion.

        Args:
            motion: The motion, which holds the limits.
            cells: Number of cells of its clock.
            limits: Of its joints.
            inverse_dynamics: Torques of the joints; None if they are not limited.
        """
        edges: Floats = np.linspace(0.0, motion.duration, FINE * cells + 1)
        # Both sides of where the jerk jumps, and the ends and the middles of slots.
        points, middles = motion.times, (edges[1:] + edges[:-1]) / 2.0
        clock = np.sort(np.concatenate((edges, middles, points - SIDE, points + SIDE)))
        clock = np.clip(clock, 0.0, motion.duration)
        q, v, a, j = (motion(clock, order) for order in range(4))
        pull = np.stack((v, a, np.zeros_like(v))) / limits.acceleration
        if inverse_dynamics is not None:
            which = np.isfinite(limits.effort)
            none, effort = np.zeros_like(q), limits.effort[which]
            held = inverse_dynamics(q, none, none)[:, which]
            along = inverse_dynamics(q, none, v)[:, which] - held
            bend = inverse_dynamics(q, v, a)[:, which] - held
            pull = np.concatenate((pull, np.stack((along, bend, held)) / effort), axis=2)
        slots = np.searchsorted(clock, edges)
        return Limited(
            cells,
            motion.duration / cells,
            *_middle_and_around(pull, slots),
            *_middle_and_around(np.stack((v, a, j)) / limits.jerk, slots),
        )

    def possible(self, of: SpeedChange, begins: Ints) -> Bools:
        """Return whether a change can begin at the starts of cells, shape (k,)."""
        z, offset = _passing(of, FINE)
        _, rate, first, second = (each[:, None] for each in of.at(z, cell=self.cell))
        at = begins[:, None] * FINE + offset
        pull = _most(self.pull, self.pull_around, at, (first, rate**2, np.ones_like(rate)))
        worst: Floats = pull.max(axis=(1, 2))
        if self.jerk[0].any():
            jerk = _most(self.jerk, self.jerk_around, at, (second, 3.0 * rate * first, rate**3))
            worst = np.maximum(worst, jerk.max(axis=(1, 2)))
        return worst <= 1.0 + TOUCH


def _middle_and_around(values: Floats, slots: Ints) -> tuple[Floats, Floats]:
    """Return the middle of values (r, k, j) over the samples of each slot, and half their range."""
    ends = values[:, slots[1:]]
    most = np.maximum(np.maximum.reduceat(values, slots[:-1], axis=1), ends)
    least = np.minimum(np.minimum.reduceat(values, slots[:-1], axis=1), ends)
    return (most + least) / 2.0, (most - least) / 2.0


def _most(middle: Floats, around: Floats, at: Ints, factors: tuple[Floats, Floats, Floats]) -> Floats:
    """Bound the size of a sum of factors times values."""
    total, apart = np.zeros(1), np.zeros(1)
    for value, off, factor in zip(middle, around, factors, strict=True):
        total, apart = total + value[at] * factor, apart + off[at] * np.abs(factor)
    return np.abs(total) + apart


@cache
def _passing(of: SpeedChange, fine: int) -> tuple[Floats, Ints]:
    """Return parts of the time of a change, and the slots that it passes then: each slot, and even times."""
    z: Floats = np.linspace(0.0, 1.0, 32 * of.span * fine + 1)
    clock = of.at(z, cell=float(fine))[0]
    middles = np.interp(np.arange(of.span * fine) + 0.5, clock, z)
    times = np.union1d(middles, np.linspace(0.0, 1.0, EVEN))
    slot = np.floor(np.interp(times, z, clock)).astype(np.int64)
    return times, np.clip(slot, 0, of.span * fine - 1)


def possible_changes(limited: Limited) -> Mapping[int, list[SpeedChange]]:
    """Return the changes that can begin at the start of each cell: to each rate the shortest that holds."""
    found: dict[int, list[SpeedChange]] = {begin: [] for begin in range(limited.cells)}
    for before in range(len(RATES)):
        for after in range(len(RATES)):
            if before == after:
                continue
            left = np.arange(limited.cells)
            for span in SPANS:
                left = left[left + span <= limited.cells]
                if not len(left):
                    break
                one = change(before, after, span)
                held = limited.possible(one, left)
                for begin in left[held].tolist():
                    found[begin].append(one)
                left = left[~held]
    return found
