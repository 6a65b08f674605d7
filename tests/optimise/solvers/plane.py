"""A point that moves in a plane past a disc, as an `Nlp` over knots without a robot."""

from dataclasses import dataclass

import numpy as np

from trajopt.optimise.nlp import ConstraintRows, CostRows, Linearisation
from trajopt.values.arrays import Floats, Ints, Loss, Rows

KNOTS = 16
CENTRE, RADIUS, REACH = np.array([0.5, 0.02]), 0.2, 0.1


@dataclass(frozen=True, eq=False)
class PlaneNlp:
    """From the origin to (1, 0): squared differences as costs, the disc as a field known near it.

    Attributes:
        goal_free: Whether the end may move, and is asked for by a constraint instead.
        band: Largest |y| all the way; none when infinite.
        ceiling: Upper bound of y as a variable.
        radius: Of the disc.
    """

    goal_free: bool = False
    band: float = np.inf
    ceiling: float = 1.0
    radius: float = RADIUS

    @property
    def scale(self) -> Floats:
        return np.ones(2)

    @property
    def lower(self) -> Floats:
        lower = np.full((KNOTS, 2), -1.0)
        lower[:, 0] = -0.5
        lower[0] = 0.0
        lower[-1] = lower[-1] if self.goal_free else (1.0, 0.0)
        return lower

    @property
    def upper(self) -> Floats:
        upper = np.full((KNOTS, 2), self.ceiling)
        upper[:, 0] = 1.5
        upper[0] = 0.0
        upper[-1] = upper[-1] if self.goal_free else (1.0, 0.0)
        return upper

    def sampling(self, x: Floats, *, fine: bool) -> Ints:
        return np.full(len(x) - 1, 6 if fine else 2)

    def linearise(self, x: Floats, sampling: Ints) -> Linearisation:
        segment = np.repeat(np.arange(len(x) - 1), sampling)
        fraction = np.concatenate([np.arange(count) / count for count in sampling])[:, None]
        at = (1.0 - fraction) * x[segment] + fraction * x[segment + 1]
        away = at - CENTRE
        distance = np.linalg.norm(away, axis=1)

        def along(value: Floats, slope: Floats, keep: Ints) -> Rows:
            parts = np.stack(((1.0 - fraction) * slope, fraction * slope), axis=1)[keep]
            knots = np.stack((segment, segment + 1), axis=1)[keep]
            place = (segment + fraction[:, 0])[keep]
            return Rows(value[keep], parts, knots, np.zeros(len(keep), dtype=np.int64), place)

        near = np.flatnonzero(distance - self.radius < REACH)
        rows = along(distance - self.radius, away / distance[:, None], near)
        free = np.full(len(near), np.inf)
        blocks = [ConstraintRows("clearance", rows, np.zeros(len(near)), free, 1e-3, REACH)]
        if np.isfinite(self.band):
            every = np.arange(len(at))
            heights = along(at[:, 1], np.tile([0.0, 1.0], (len(at), 1)), every)
            limit = np.full(len(at), self.band)
            blocks.append(ConstraintRows("band", heights, -limit, limit, 1e-3))
        if self.goal_free:
            last = np.full((2, 1), len(x) - 1)
            rows = Rows(x[-1].copy(), np.eye(2)[:, None, :], last, np.arange(2), last[:, 0] * 1.0)
            goal = np.array([1.0, 0.0])
            blocks.append(ConstraintRows("goal", rows, goal, goal, 1e-4))
        return Linearisation(x, (_differences(x),), tuple(blocks), sampling)


def _differences(x: Floats) -> CostRows:
    value = np.diff(x, axis=0)
    count, joints = value.shape
    pair = np.stack((-np.eye(joints), np.eye(joints)), axis=1)
    first = np.repeat(np.arange(count), joints)
    rows = Rows(
        value.ravel(), np.tile(pair, (count, 1, 1)), np.stack((first, first + 1), axis=1),
        np.tile(np.arange(joints), count), first + 0.5,
    )  # fmt: skip
    return CostRows("length", rows, np.ones(count * joints), Loss.SQUARED)


def straight() -> Floats:
    return np.linspace((0.0, 0.0), (1.0, 0.0), KNOTS)
