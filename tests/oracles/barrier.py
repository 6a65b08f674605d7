"""Minimises a `Program` from within: Newton steps on its duration plus a barrier at every limit.

Each step takes the tangent of the jerk rows' limits at hand, so that the barrier's Hessian is positive
definite and no step within the tangents leaves the limits themselves. The barrier gets smaller until it
holds the duration up by a known part: the number of rows over the weight of the duration.

Source: Boyd and Vandenberghe, Convex Optimization, 2004, chapter 11.
"""

from dataclasses import dataclass

import numpy as np

from tests.oracles.retiming.jerk_program import NothingFits, Program
from trajopt.values.arrays import Floats

TIGHTER = 0.1
"""Factor of the gap from one barrier to the next."""
STEPS = 12
"""Most Newton steps for one barrier."""
SETTLED = 5e-4
"""Squared Newton decrement for each row at which the next barrier is taken."""
START = 0.9
"""Part of the fastest uniform profile, squared speeds, with which the search begins."""
SCALINGS = 200
"""Most doublings of the squared speeds, and half the most halvings, until a profile is within all limits:
motions that are faster or slower by 2^100 mean nothing."""
HALVINGS = 20
"""Most halvings of a step that makes nothing better; then rounding errors rule."""
ARMIJO = 0.1
"""Part of the predicted decrease that a step must bring."""
NEAR = 0.95
"""Part of the way to the nearest limit that a step may go."""


@dataclass(frozen=True, eq=False)
class Minimum:
    """What came out.

    Attributes:
        z: Control values within all limits, shape (k + 1,).
        steps: Newton steps taken.
    """

    z: Floats
    steps: int


def windows(z: Floats) -> Floats:
    """Three neighbouring control values for each interval: (k + 1,) -> (k - 1, 3)."""
    return np.stack((z[:-2], z[1:-1], z[2:]), axis=1)


@dataclass(frozen=True, eq=False)
class State:
    """A program at some control values: how far all rows are from their limits.

    Attributes:
        z: The control values, shape (k + 1,).
        above: Distance of the values from their upper limits, shape (k - 1, m + r).
        below: Distance from their lower limits, shape (k - 1, m + r).
        slope: Derivative of each jerk row's limit by y, shape (k - 1, r).
    """

    z: Floats
    above: Floats
    below: Floats
    slope: Floats

    @property
    def inside(self) -> bool:
        """Whether all rows hold with something left."""
        return bool(self.above.min() > 0.0 and self.below.min() > 0.0)


def at(program: Program, z: Floats) -> State:
    """Evaluate all rows at positive control values."""
    window = windows(z)
    values = (program.rows @ window[:, :, None])[:, :, 0]
    half = program.jerk.shape[1] // 2
    y = np.repeat((program.speed @ window[:, :, None])[:, :, 0], half, axis=1)
    limit = program.jerk / np.sqrt(y)
    return State(
        z,
        np.hstack((program.above, limit)) - values,
        np.hstack((program.below, limit)) + values,
        limit / (-2.0 * y),
    )


def duration(program: Program, z: Floats) -> float:
    """Return about what the motion takes [s]."""
    return float((program.weight / np.sqrt(z)).sum())


def minimise(program: Program, z: Floats, *, first_gap: float, gap: float) -> Minimum:
    """Find control values of nearly the least duration.

    Args:
        program: The program.
        z: Positive control values to start from, the first two equal and the last two, shape (k + 1,).
        first_gap: Part of the duration that the first barrier leaves open.
        gap: Part of the duration that may be missing to the least.
    """
    steps, state = 0, at(program, scaled_inside(program, z))
    rows = 2 * state.above.size + len(z)
    open_ = first_gap
    while True:
        weight = rows / (open_ * duration(program, state.z))
        for _ in range(STEPS):
            found, decrement = _step(program, state, weight)
            steps += 1
            if found is None:
                break
            state = found
            if decrement < SETTLED * rows:
                break
        if open_ <= gap:
            return Minimum(state.z, steps)
        open_ = max(gap, open_ * TIGHTER)


def scaled_inside(program: Program, z: Floats) -> Floats:
    """Run a profile slower or faster, uniformly, until it is well within all limits.

    Args:
        program: The program.
        z: Positive control values, shape (k + 1,).

    Raises:
        NothingFits: If it is outside at every speed.
    """

    def fits(factor: float) -> bool:
        return bool((z * factor < program.bound).all()) and at(program, z * factor).inside

    factor = 1.0
    for _ in range(SCALINGS):
        if not fits(factor):
            break
        factor *= 2.0
    for _ in range(2 * SCALINGS):
        if fits(factor):
            break
        factor /= 2.0
    if not fits(factor):
        raise NothingFits
    for part in (1.5, 1.25):
        if fits(factor * part):
            factor *= part
    return z * (factor * START)


def _merit(program: Program, state: State, weight: float) -> float:
    left = program.bound - state.z
    if not state.inside or not (left.min() > 0.0 and state.z.min() > 0.0):
        return np.inf
    barrier = np.log(state.above).sum() + np.log(state.below).sum() + np.log(left).sum()
    return weight * duration(program, state.z) - float(barrier)


def _step(program: Program, state: State, weight: float) -> tuple[State | None, float]:
    """Take one Newton step, if it makes anything better; also return the squared Newton decrement."""
    from scipy.linalg import solveh_banded

    gradient, bands = _derivatives(program, state, weight)
    found: Floats = -solveh_banded(bands, gradient, lower=True, check_finite=False)
    decrement = -float(gradient @ found)
    direction = np.concatenate((found[:1], found, found[-1:]))
    part = min(1.0, NEAR * _reach(program, state, direction))
    merit = _merit(program, state, weight)
    for _ in range(HALVINGS):
        trial = at(program, state.z + part * direction)
        if _merit(program, trial, weight) <= merit - ARMIJO * part * decrement:
            return trial, decrement
        part /= 2.0
    return None, decrement


def _reach(program: Program, state: State, direction: Floats) -> float:
    """Return how far along a direction all limits, the jerk's by their tangents, hold."""
    window = windows(direction)
    values = (program.rows @ window[:, :, None])[:, :, 0]
    half = program.jerk.shape[1] // 2
    y = np.repeat((program.speed @ window[:, :, None])[:, :, 0], half, axis=1)
    lowered = np.zeros_like(values)
    lowered[:, program.above.shape[1] :] = state.slope * y
    used = max(
        float(((values - lowered) / state.above).max()), float(((-values - lowered) / state.below).max())
    )
    used = max(
        used, float((direction / (program.bound - state.z)).max()), float((-direction / state.z).max())
    )
    return 1.0 / used if used > 0.0 else np.inf


def _derivatives(program: Program, state: State, weight: float) -> tuple[Floats, Floats]:
    """Return the gradient of the merit and the three bands of its Hessian (with tangents)."""
    z, rows, linear = state.z, program.rows, program.above.shape[1]
    up, down = 1.0 / state.above, 1.0 / state.below
    left = 1.0 / (program.bound - z)
    cost = weight * program.weight * z**-1.5
    gradient = -0.5 * cost + left
    diagonal = 0.75 * cost / z + left**2

    pull, both, apart = up - down, up**2 + down**2, up**2 - down**2
    count, half = len(rows), program.jerk.shape[1] // 2
    slope = state.slope.reshape(count, 2, half)
    total = (up + down)[:, linear:].reshape(count, 2, half)
    of_speed = -(slope * total).sum(axis=2)
    block = (pull[:, None] @ rows)[:, 0] + (of_speed[:, None] @ program.speed)[:, 0]
    hessian = (rows * both[:, :, None]).swapaxes(1, 2) @ rows
    scaled = (apart[:, linear:] * state.slope)[:, :, None] * rows[:, linear:]
    crossed = scaled.reshape(count, 2, half, 3).sum(axis=2)
    mixed = crossed.swapaxes(1, 2) @ program.speed
    square = (slope**2 * both[:, linear:].reshape(count, 2, half)).sum(axis=2)
    hessian += (program.speed * square[:, :, None]).swapaxes(1, 2) @ program.speed
    hessian -= mixed + mixed.swapaxes(1, 2)

    bands = np.zeros((3, len(z)))
    bands[0] = diagonal
    for i in range(3):
        gradient[i : i + count] += block[:, i]
        for j in range(i, 3):
            bands[j - i, i : i + count] += hessian[:, i, j]
    return _tied(gradient, bands)


def _tied(gradient: Floats, bands: Floats) -> tuple[Floats, Floats]:
    """Let the first two control values be one unknown, and the last two."""
    gradient[[1, -2]] += gradient[[0, -1]]
    bands[0, 1] += bands[0, 0] + 2.0 * bands[1, 0]
    bands[1, 1] += bands[2, 0]
    bands[0, -2] += bands[0, -1] + 2.0 * bands[1, -2]
    bands[1, -3] += bands[2, -3]
    inner = bands[:, 1:-1].copy()
    inner[1, -1:] = inner[2, -2:] = 0.0
    return gradient[1:-1], inner
