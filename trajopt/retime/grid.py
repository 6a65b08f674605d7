"""Where a path is cut into intervals: at its knots, and between them evenly in time."""

import numpy as np

from trajopt.arrays import Bools, Floats
from trajopt.retime.profile import Profile

TURN = 0.25
"""How far a path may turn in an interval [rad]: at sharp corners the speed changes fast."""
MOST_BENDS = 150.0
"""Most intervals that are added because a path turns."""


def first_grid(knots: Floats, count: int) -> Floats:
    """Cut a path when nothing is known of its speed but that it starts and ends at rest.

    The cuts are even in the phase of `_phase`, which from rest grows as time does.

    Args:
        knots: Knots of the smooth path, increasing from 0, shape (k,).
        count: Intervals to aim at.

    Returns:
        Grid with all the knots in it, increasing.
    """
    phase = _phase(knots, float(knots[-1]))
    cuts, places = _cut(phase, count)
    return _grid(knots, cuts, places)


def even_grid(knots: Floats, profile: Profile, turning: Floats, count: int) -> Floats:
    """Cut a path so that a profile takes about the same time in each interval, and less in bends.

    Args:
        knots: Knots of the smooth path, all of them in the grid of the profile, shape (k,).
        profile: A profile of the path.
        turning: How far the path has turned at each grid point of the profile [rad].
        count: Intervals to aim at on a straight path.

    Returns:
        Grid with all the knots in it, increasing.
    """
    bend = min(1.0 / TURN, MOST_BENDS / max(float(turning[-1]), 1e-9))
    clock = profile.times * (count / profile.duration) + turning * bend
    places = np.searchsorted(profile.s, knots)
    cuts, marks = _cut(clock[places], round(float(clock[-1])))
    phase = _phase(profile.s, float(knots[-1]))
    return _grid(knots, np.interp(cuts, clock, phase), marks)


def finer_grid(s: Floats, coarse: Bools) -> Floats:
    """Halve intervals that are too coarse, and those beside them.

    Args:
        s: Grid, shape (k,).
        coarse: Which intervals are, shape (k - 1,).
    """
    halved = coarse.copy()
    halved[1:] |= coarse[:-1]
    halved[:-1] |= coarse[1:]
    return np.sort(np.concatenate((s, ((s[:-1] + s[1:]) / 2.0)[halved])))


def turned(s: Floats, dq: Floats, ddq: Floats, velocity: Floats) -> Floats:
    """How far a path has turned: the angle of its tangent, summed up, in joints over their speeds.

    Args:
        s: Grid, shape (k,).
        dq: dq/ds there, shape (k, n).
        ddq: d²q/ds² there, shape (k, n).
        velocity: Velocity limits, shape (n,); where zero, the joint stands still.

    Returns:
        Shape (k,), from 0 [rad].
    """
    scale = np.where(velocity > 0.0, velocity, 1.0)
    tangent, change = dq / scale, ddq / scale
    size = np.maximum(np.linalg.norm(tangent, axis=1), 1e-9 * np.abs(tangent).max())[:, None]
    direction = tangent / size
    across = change - direction * (direction * change).sum(axis=1)[:, None]
    rate = np.linalg.norm(across / size, axis=1)
    # A reversal turns by half a turn at once, where the rate has a pole: no interval turns farther.
    steps = np.minimum((rate[:-1] + rate[1:]) / 2.0 * np.diff(s), np.pi)
    return np.concatenate(((0.0,), np.cumsum(steps)))


def _phase(s: Floats, length: float) -> Floats:
    """Part of a half turn whose cosine runs along the path: near both ends like sqrt(distance)."""
    return np.arccos(np.clip(1.0 - 2.0 * s / length, -1.0, 1.0)) / np.pi


def _cut(clock: Floats, count: int) -> tuple[Floats, list[int]]:
    """Cut each span between knots into equal parts of a clock; also the places of the knots."""
    steps = np.diff(clock)
    parts = np.maximum(1, np.rint(steps * (count / (clock[-1] - clock[0])))).astype(np.int64)
    places = [0, *np.cumsum(parts).tolist()]
    return np.interp(np.arange(places[-1] + 1), places, clock), places


def _grid(knots: Floats, phase: Floats, places: list[int]) -> Floats:
    grid = float(knots[-1]) * np.sin(np.pi / 2.0 * phase) ** 2
    grid[places] = knots
    return grid
