"""Self-motion of a redundant arm: neighbouring configurations that hold the same goal."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from trajopt.geometry import evaluator
from trajopt.optimise.kinematics.projection import Projection
from trajopt.optimise.kinematics.validity import clear, missed_at, requirements_of
from trajopt.problem.requirements import Requirement
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Bools, Floats, Value, floats, number, one_of, readonly
from trajopt.values.errors import JointNotFound, ProblemError, ShapeError, shown
from trajopt.values.errors.arguments import checked

STEP = 0.05
"""Step of the fastest joint from one configuration to the next [rad | m]."""
SMALLEST_SHARE = 1 / 16
"""A step that must be shorter than this share of `step` ends the sweep."""
MOST = 2000
"""Most configurations of a sweep, each way."""
RANK_TOLERANCE = 1e-6
"""Singular values below this share of the largest count as zero."""


@dataclass(frozen=True, eq=False)
class SelfMotion(Value):
    """A family of configurations that hold the same goal.

    Attributes:
        positions: One next to the other, shape (k, n) [rad | m].
        free: Which of them touch nothing, shape (k,).
        begin: Index of the configuration that the sweep began at.
        closed: Whether the last is next to the first again.
    """

    positions: Floats
    free: Bools
    begin: int
    closed: bool

    def __str__(self) -> str:
        ring = "a closed loop" if self.closed else "ended by limits"
        return f"{len(self.positions)} configurations, {int(self.free.sum())} of them free, {ring}"


@checked
def self_motion(
    reduced: ReducedModel,
    goal: Requirement | Sequence[Requirement],
    positions: ArrayLike,
    *,
    joint: str | None = None,
    step: float = STEP,
) -> SelfMotion:
    """Sweep along the null space of a goal, both ways, until limits end it or it closes.

    Steps along the null space of the goal's Jacobian are corrected by projection (Allgower and Georg,
    Introduction to numerical continuation methods, ch. 2). In a null space of several dimensions the sweep
    keeps its first direction.

    Args:
        goal: Requirement to hold, such as `frame_placement(...)`.
        positions: Configuration to begin at, which must hold the goal, shape (n,) [rad | m].
        joint: Joint whose motion leads, upward first; the most mobile one when None.
        step: Step of the fastest joint from one configuration to the next [rad | m].

    Raises:
        ProblemError: If the goal does not hold at the beginning, or leaves no freedom there.
        JointNotFound: If the joint is not in the group.
        ShapeError: If the positions or the step are invalid.
    """
    begin = floats("positions", positions, (len(reduced.joint_names),))
    if not number("step", step) > 0.0:
        raise ShapeError("step", f"must be positive, is {step:g}")
    if joint is not None and one_of("joint", joint, str) not in reduced.joint_names:
        raise JointNotFound("joint in the group", joint, reduced.joint_names)
    wanted = requirements_of(reduced, "goal", goal)
    query = evaluator(reduced)
    sweep = _Sweep(reduced, Projection(reduced, wanted, query), step)
    if float(sweep.projection.violation(begin[None])[0]) > 0.0:
        miss = missed_at(reduced, wanted, begin)
        raise ProblemError(f"the goal does not hold where the sweep begins: missed by {miss}")
    onward = sweep.first_direction(begin, joint)
    ahead, closed = sweep.march(begin, onward)
    behind = [] if closed else sweep.march(begin, -onward)[0]
    line = np.array([*reversed(behind), begin, *ahead])
    free = clear(query, line, reduced.pairs.required)
    return SelfMotion(readonly(line), free, len(behind), closed)


class _Sweep:
    def __init__(self, reduced: ReducedModel, projection: Projection, step: float) -> None:
        self.projection = projection
        self._reduced, self._step = reduced, step
        self._whole = np.where(np.isfinite(reduced.limits.upper - reduced.limits.lower), np.inf, 2.0 * np.pi)

    def first_direction(self, begin: Floats, joint: str | None) -> Floats:
        null = self._null_space(begin)
        freedom = np.linalg.norm(null, axis=0)
        names = self._reduced.joint_names
        place = int(np.argmax(freedom)) if joint is None else names.index(joint)
        if freedom[place] < RANK_TOLERANCE:
            what = f"joint {shown(joint)} cannot move" if joint else "no joint can move"
            raise ProblemError(f"{what} there while the goal is held")
        return _scaled(null.T @ null[:, place])

    def march(self, begin: Floats, direction: Floats) -> tuple[list[Floats], bool]:
        """Step until limits or a turn back; return the configurations, and whether the sweep closed."""
        found: list[Floats] = []
        here, size = begin, self._step
        while len(found) < MOST and size >= SMALLEST_SHARE * self._step:
            ended = self.projection((here + size * direction)[None])
            there = ended.positions[0]
            moved = there - here
            onward = float(moved @ direction) / float(direction @ direction)
            if ended.violation[0] > 0.0 or np.abs(moved).max() > 2.0 * size or onward < 0.5 * size:
                size *= 0.5
                continue
            if len(found) > 2 and self._apart(there, begin) < 0.75 * self._step:
                return found, True
            found.append(there)
            null = self._null_space(there)
            direction = _scaled(null.T @ (null @ direction))
            here, size = there, min(2.0 * size, self._step)
        return found, False

    def _apart(self, one: Floats, other: Floats) -> float:
        apart = np.abs(one - other)
        turns = np.where(np.isinf(self._whole), 0.0, np.round(apart / self._whole))
        return float(np.abs(apart - turns * 2.0 * np.pi).max())

    def _null_space(self, positions: Floats) -> Floats:
        jacobian: Floats = self.projection.jacobian(positions[None])[0]
        _, values, right = np.linalg.svd(jacobian)
        rank = int((values > RANK_TOLERANCE * values.max(initial=0.0)).sum())
        return np.asarray(right[rank:], dtype=np.float64)


def _scaled(direction: Floats) -> Floats:
    return direction / np.abs(direction).max()
