"""Squared differences of knots: velocity, acceleration and jerk of a path without time.

Forms of Tesseract's TrajOpt (Schulman et al., IJRR 2014, eq. 8), without a time step:
v_t = q_{t+1} - q_t, a_t = q_{t+2} - 2 q_{t+1} + q_t, j_t = q_{t+3} - 3 q_{t+2} + 3 q_{t+1} - q_t.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import comb

import numpy as np

from trajopt.problem.motion import Motion
from trajopt.problem.residual import Cost
from trajopt.values.arrays import Floats, Ints, Rows, readonly


def _differences(knots: Floats, order: int) -> Rows:
    windows = max(len(knots) - order, 0)
    value = np.zeros((windows, knots.shape[1]))
    for k, factor in enumerate(_factors(order)):
        value += factor * knots[k : k + windows]
    return Rows(value.ravel(), *_stencils(*knots.shape, order))


def _factors(order: int) -> list[float]:
    return [(-1.0) ** (order - k) * comb(order, k) for k in range(order + 1)]


@lru_cache(maxsize=32)
def _stencils(count: int, joints: int, order: int) -> tuple[Floats, Ints, Ints, Floats]:
    windows = max(count - order, 0)
    block = np.array(_factors(order))[None, :, None] * np.eye(joints)[:, None, :]
    first = np.repeat(np.arange(windows, dtype=np.int64), joints)
    return (
        readonly(np.tile(block, (windows, 1, 1))),
        first[:, None] + np.arange(order + 1),
        np.tile(np.arange(joints, dtype=np.int64), windows),
        readonly(first.astype(np.float64) + order / 2),
    )


@dataclass(frozen=True)
class Velocity:
    """First differences of the knots, one component per joint [rad | m]."""

    name = "velocity"

    def linearise(self, motion: Motion) -> Rows:
        return _differences(motion.knots, 1)


@dataclass(frozen=True)
class Acceleration:
    """Second differences of the knots, one component per joint [rad | m]."""

    name = "acceleration"

    def linearise(self, motion: Motion) -> Rows:
        return _differences(motion.knots, 2)


@dataclass(frozen=True)
class Jerk:
    """Third differences of the knots, one component per joint [rad | m]."""

    name = "jerk"

    def linearise(self, motion: Motion) -> Rows:
        return _differences(motion.knots, 3)


def default_costs() -> tuple[Cost, ...]:
    return (Cost(Velocity()), Cost(Acceleration()))
