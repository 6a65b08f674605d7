"""A program over one configuration: some requirements must hold, others give way where they must.

What gives way is penalised by the L1 norm of its violation, the elastic relaxation: it leaves a
requirement alone if it can, and breaks it along few directions if it cannot. Source: Nocedal and Wright,
Numerical Optimization (2006), section 17.2.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.geometry import Query
from trajopt.optimise.nlp import ConstraintRows, CostRows, Linearisation
from trajopt.optimise.solvers import Sqp
from trajopt.optimise.terms import Clearance, Constraint, constrain, constraint
from trajopt.optimise.terms.gravity_torque import HoldingTorque
from trajopt.optimise.transcription.holding import LISTED
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import Requirement, together
from trajopt.problem.residual import WHOLE, units_of
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Ints
from trajopt.values.rows import Loss, Rows

ELASTIC = 10.0
"""Weight of what gives way, by metre or radian of its violation."""
SOLVER = Sqp(max_iterations=60, relative_gain=1e-4, absolute_gain=1e-7)
"""One configuration costs little, so it is worth solving well."""
HELD = 0.998
"""Share of an effort limit that holding still may take: nearly all, as the least change is looked for."""
CLEARANCE_TOLERANCE = 1e-4
"""A margin counts as held when undercut by no more than this [m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ConfigurationProblem:
    """What one configuration must hold; see the module.

    Attributes:
        reduced: The robot and its surroundings.
        hard: What must hold.
        soft: What gives way.
        clear: Whether the margins of all pairs must hold.
        near: Configuration to stay near, shape (n,) [rad | m].
        stay: Weight of staying near, by squared distance.
        effort: Effort limits within which the joints must hold the arm and what it carries still, shape (n,)
            [Nm | N]; not required when None.
    """

    reduced: ReducedModel
    hard: Sequence[Requirement]
    soft: Sequence[Requirement]
    clear: bool
    near: Floats
    stay: float
    effort: Floats | None = None

    def solve(self, begin: Floats, query: Query) -> "ConfigurationSolution":
        """Return the configuration that a start of shape (n,) leads to."""
        nlp = _OneKnotNlp(self, query)
        solved = SOLVER.solve(nlp, begin[None])
        soft = sum(block.cost / ELASTIC for block in solved.at.costs if block.loss is Loss.HINGE)
        return ConfigurationSolution(solved.x[0], solved.feasible, float(soft), solved.at)


@dataclass(frozen=True, eq=False)
class ConfigurationSolution:
    """Where a start led to.

    Attributes:
        positions: Shape (n,) [rad | m].
        holds: Whether everything that must hold does.
        given: By how much the rest gave way, in all [m and rad].
        at: Everything linearised there.
    """

    positions: Floats
    holds: bool
    given: float
    at: Linearisation


class _OneKnotNlp:
    """The program: an `Nlp` of one knot."""

    def __init__(self, asked: ConfigurationProblem, query: Query) -> None:
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
        """Return the samples of no segments at all."""
        del fine
        return np.zeros(len(x) - 1, dtype=np.int64)

    def linearise(self, x: Floats, sampling: Ints) -> Linearisation:
        """Evaluate and linearise at the one configuration."""
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
    """Return a constraint's excess over both of its bounds as costs with a kink."""
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
