"""The nearest free configuration, by optimisation from many starts; and conflicting requirements."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from trajopt.geometry import Evaluator, evaluator
from trajopt.optimise.kinematics.inverse import random_starts
from trajopt.optimise.kinematics.projection import Projection
from trajopt.optimise.nlp import ConstraintRows, CostRows, Linearisation
from trajopt.optimise.solvers import Sqp
from trajopt.optimise.terms import Clearance, Constraint, constrain, constraint
from trajopt.optimise.terms.gravity_torque import HoldingTorque
from trajopt.optimise.transcription.knots import LISTED
from trajopt.planning.infeasibility.reasons import Obstruction, ObstructionKind
from trajopt.problem.motion import Motion
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import Requirement, together
from trajopt.problem.residual import WHOLE, units_of
from trajopt.scene.bounds import largest_gravity_torques
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Ints, Loss, Rows, Value, readonly
from trajopt.verify import Moment, examine

ELASTIC = 10.0
"""Weight of violations of relaxed requirements, per metre or radian."""
SOLVER = Sqp(max_iterations=60, relative_gain=1e-4, absolute_gain=1e-7)
"""One configuration is cheap, so it is solved tightly."""
HELD = 0.998
"""Share of an effort limit for holding still: nearly all, to find the smallest change."""
CLEARANCE_TOLERANCE = 1e-4
"""Accepted violation of a margin [m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ConfigurationProblem:
    """The requirements on one configuration; see the module.

    Attributes:
        soft: Requirements that may be violated at a cost.
        clear: Whether the margins of all pairs must hold.
        near: Preferred configuration, shape (n,) [rad | m].
        effort: Effort limits for holding the arm and its load still, shape (n,)
            [Nm | N]; not required if None.
    """

    reduced: ReducedModel
    hard: Sequence[Requirement]
    soft: Sequence[Requirement]
    clear: bool
    near: Floats
    stay: float
    effort: Floats | None = None

    def solve(self, begin: Floats, query: Evaluator) -> "ConfigurationSolution":
        nlp = _OneKnotNlp(self, query)
        solved = SOLVER.solve(nlp, begin[None])
        soft = sum(block.cost / ELASTIC for block in solved.at.costs if block.loss is Loss.HINGE)
        return ConfigurationSolution(solved.x[0], solved.feasible, float(soft))


@dataclass(frozen=True, eq=False)
class ConfigurationSolution:
    """A local solution.

    Attributes:
        positions: Shape (n,) [rad | m].
        given: Total violation of the soft requirements [m and rad].
    """

    positions: Floats
    holds: bool
    given: float


class _OneKnotNlp:
    def __init__(self, asked: ConfigurationProblem, query: Evaluator) -> None:
        reduced, limits = asked.reduced, asked.reduced.limits
        self._asked, self._query = asked, query
        self._hard = [item for need in together(asked.hard) for item in constrain(need, reduced, WHOLE)]
        if asked.clear:
            self._hard.append(
                constraint(Clearance(reduced), lower=0.0, upper=np.inf, tolerance=CLEARANCE_TOLERANCE)
            )
        if asked.effort is not None:
            held = HoldingTorque(asked.effort, np.full_like(asked.effort, HELD - LISTED))
            self._hard.append(constraint(held, lower=-HELD, upper=HELD, tolerance=0.5 * (1.0 - HELD)))
        self._soft = [item for need in asked.soft for item in constrain(need, reduced, WHOLE)]
        self.lower, self.upper = np.array(limits.lower)[None], np.array(limits.upper)[None]
        self.scale = np.ones(len(limits.lower))

    def sampling(self, x: Floats, *, fine: bool) -> Ints:
        del fine
        return np.zeros(len(x) - 1, dtype=np.int64)

    def linearise(self, x: Floats, sampling: Ints) -> Linearisation:
        motion, count = Motion.each(x, self._query), int(x.shape[1])
        order = np.arange(count, dtype=np.int64)
        stay = Rows(
            x[0] - self._asked.near,
            np.eye(count)[:, None, :],
            np.zeros((count, 1), dtype=np.int64),
            order,
            np.zeros(count),
        )
        costs = [CostRows("stay", stay, np.full(count, self._asked.stay), Loss.SQUARED)]
        costs += [_elastic(item, motion) for item in self._soft]
        hard = [_bounded(item, motion) for item in self._hard]
        return Linearisation(x, tuple(costs), tuple(hard), sampling)


def _rows(item: Constraint, motion: Motion) -> Rows:
    rows = item.residual.linearise(motion)
    return Rows(rows.value, rows.jacobian[:, :1], rows.knots[:, :1], rows.component, rows.place)


def _bounded(item: Constraint, motion: Motion) -> ConstraintRows:
    rows = _rows(item, motion)
    lower, upper = item.bounds(rows)
    residual = item.residual
    kind, units = type(residual), units_of(residual)
    return ConstraintRows(residual.name, rows, lower, upper, item.tolerance, kind=kind, units=units)


def _elastic(item: Constraint, motion: Motion) -> CostRows:
    rows = _rows(item, motion)
    lower, upper = item.bounds(rows)
    above, below = np.flatnonzero(np.isfinite(upper)), np.flatnonzero(np.isfinite(lower))
    both = np.concatenate((above, below))
    sign = np.concatenate((np.ones(len(above)), -np.ones(len(below))))
    excess = np.concatenate((rows.value[above] - upper[above], lower[below] - rows.value[below]))
    doubled = Rows(
        excess,
        rows.jacobian[both] * sign[:, None, None],
        rows.knots[both],
        rows.component[both],
        rows.place[both],
    )
    residual = item.residual
    return CostRows(residual.name, doubled, np.full(len(both), ELASTIC), Loss.HINGE, type(residual))


STARTS = 128
"""Number of starts in the search of the goal."""
POLISHED = 6
"""Number of these to optimise, the nearest ones."""
SPREADS = (0.0, 0.1, 0.3, 0.6, 1.0)
"""Standard deviations of starts around a configuration [rad | m]."""
SEED = 0
"""Seed of the generator, for reproducible explanations."""
STAY = 1e-3
"""Weight of staying near the start if the goal is relaxed."""


@dataclass(frozen=True, eq=False)
class NearestFree(Value):
    """A free configuration, confirmed by the judge, near one that is not.

    Attributes:
        positions: Of the group's joints, shape (n,) [rad | m].
        moved: Change of each joint from its required position, or for a searched goal from the start, shape
            (n,) [rad | m].
        given: Violation of the softened goal there [m and rad]; 0 for joint positions.
        clearance: Smallest distance there, by the judge [m]; inf without pairs.
    """

    positions: Floats
    moved: Floats
    given: float
    clearance: float

    def as_dict(self) -> dict[str, object]:
        """Return plain JSON data."""
        return {
            "positions": self.positions.tolist(),
            "moved": self.moved.tolist(),
            "given": self.given,
            "clearance": self.clearance if np.isfinite(self.clearance) else None,
        }


def nearest_free(problem: Problem, positions: Floats, moment: Moment) -> NearestFree | None:
    """Find the nearest configuration that is clear, can be held still and meets the path constraints.

    Args:
        positions: The configuration that is not free, shape (n,) [rad | m].

    Returns:
        The nearest one found, or None.
    """
    reduced, rng = problem.reduced, np.random.default_rng(SEED)
    always = (
        problem.requirements_at(0) if moment is Moment.START else problem.requirements_at(problem.last_stop)
    )
    asked = ConfigurationProblem(
        reduced=reduced, hard=always, soft=(), clear=True, near=positions, stay=1.0, effort=_effort(problem)
    )
    query = evaluator(reduced)
    starts = [
        positions + rng.normal(scale=spread, size=positions.shape) for spread in SPREADS for _ in (0, 1)
    ]
    stood = [asked.solve(np.clip(q, reduced.limits.lower, reduced.limits.upper), query) for q in starts]
    return _best(problem, positions, stood, moment)


def least_missed(
    problem: Problem, soft: Sequence[Requirement], *, hard: Sequence[Requirement], clear: bool = True
) -> NearestFree | None:
    """Find a goal configuration with the smallest violation of some requirements.

    Args:
        clear: Whether it must be clear of everything, and let the joints hold still.

    Returns:
        The one with the smallest violation, then nearest to the start, or None.
    """
    reduced, rng = problem.reduced, np.random.default_rng(SEED)
    query, near = evaluator(reduced), reduced.start_positions
    begin = random_starts(reduced, rng, STARTS)
    ended = Projection(reduced, (*soft, *hard), query)(begin)
    order = np.argsort(ended.violation, kind="stable")[:POLISHED]
    effort = _effort(problem) if clear else None
    asked = ConfigurationProblem(
        reduced=reduced, hard=hard, soft=soft, clear=clear, near=near, stay=STAY, effort=effort
    )
    starts = [*ended.positions[order], *begin[: POLISHED // 2]]
    moment = Moment.END if clear else None
    if not soft:
        # Any that holds is as good as another.
        each = (_best(problem, near, [asked.solve(start, query)], moment) for start in starts)
        return next((found for found in each if found is not None), None)
    return _best(problem, near, [asked.solve(start, query) for start in starts], moment)


def _effort(problem: Problem) -> Floats | None:
    effort = problem.limits.effort
    return effort if (largest_gravity_torques(problem.reduced) > effort).any() else None


def _best(
    problem: Problem, positions: Floats, stood: Sequence[ConfigurationSolution], moment: Moment | None
) -> NearestFree | None:
    reduced = problem.reduced
    for each in sorted(
        (item for item in stood if item.holds),
        key=lambda item: (round(item.given, 3), float(np.abs(item.positions - positions).max())),
    ):
        clearance = np.inf
        if moment is not None:
            seen = examine(reduced, each.positions, moment=moment)
            if not seen.clear:
                continue
            clearance = np.inf if seen.smallest is None else seen.smallest.distance
        moved = readonly(each.positions - positions)
        return NearestFree(readonly(np.array(each.positions)), moved, each.given, clearance)
    return None


@dataclass(frozen=True, eq=False)
class _Obstacle:
    name: str

    def __str__(self) -> str:
        return f"clearance from {self.name}"


def conflict_at_goal(problem: Problem, blocks: Sequence[Obstruction]) -> tuple[str, ...]:
    """Return a minimal set of requirements and obstacles that exclude each other at the goal, in words.

    Joint limits and the robot's clearance from itself always count. Empty if other parts of the scene block
    the goal too.

    Args:
        blocks: Contacts at the goal, the most likely obstacles first.
    """
    touched = {name for block in blocks if block.kind is ObstructionKind.CONTACT for name in block.subjects}
    near = [_Obstacle(name) for name in problem.scene.objects if name in touched]
    kept: list[Requirement | _Obstacle] = [*problem.goals, *problem.requirements_at(problem.last_stop), *near]
    if _can_be_held(problem, kept):
        return ()
    for item in tuple(kept):
        rest = [other for other in kept if other is not item]
        if not _can_be_held(problem, rest):
            kept = rest
    return tuple(str(item) for item in kept)


def _can_be_held(problem: Problem, kept: Sequence[Requirement | _Obstacle]) -> bool:
    obstacles = {item.name for item in kept if isinstance(item, _Obstacle)}
    scene = problem.scene
    for name in scene.objects:
        if name not in obstacles:
            scene = scene.allow(name)
    requirements = [item for item in kept if isinstance(item, Requirement)]
    return least_missed(replace(problem, scene=scene), (), hard=requirements) is not None
