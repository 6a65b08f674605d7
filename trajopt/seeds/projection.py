"""Configurations moved until they hold requirements: Levenberg-Marquardt on many starts at once.

The residuals and derivatives are those of the program's own terms, so every requirement that has a
term can be a goal, alone or with others, and what is found here is what the program asks for.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Bools, Floats
from trajopt.model.limits import JointLimits
from trajopt.model.reduced import ReducedModel
from trajopt.model.requirements import Requirement
from trajopt.query import Query
from trajopt.terms import Constraint, constrain
from trajopt.terms.motion import Motion
from trajopt.terms.residual import WHOLE

STEPS = 15
"""Steps from each start at most; more find few further solutions."""
AIM = 0.5
"""Share of each tolerance that the search keeps in hand, so that it ends inside what is accepted."""
NARROW = 1e-2
"""Components whose bounds are nearer to each other than this aim at the middle, always [m | rad]."""
LEAST_DAMPING = 1e-8
"""Damping where nothing is violated any more; keeps the normal equations regular."""


@dataclass(frozen=True, eq=False)
class Projected:
    """Where the search ended.

    Attributes:
        positions: Shape (S, n) [rad | m], inside the limits.
        violation: How far each is from holding the requirements, shape (S,) [m and rad]; 0 if it does.
    """

    positions: Floats
    violation: Floats


@dataclass(frozen=True, eq=False)
class _Linearised:
    """Requirements at S configurations.

    Attributes:
        error: What to bring to zero, shape (S, d).
        jacobian: Its derivative; zero in rows that hold anyway, shape (S, d, n).
        violation: Shape (S,).
    """

    error: Floats
    jacobian: Floats
    violation: Floats


class Projection:
    """Moves configurations until they hold requirements."""

    def __init__(self, reduced: ReducedModel, goals: Sequence[Requirement], query: Query) -> None:
        """Take the terms of the requirements.

        Args:
            reduced: The robot and its surroundings.
            goals: What must hold, together.
            query: Evaluates the kinematics.
        """
        self._query = query
        self._limits: JointLimits = reduced.limits
        self._items: list[tuple[Constraint, Constraint]] = []
        for goal in goals:
            aims = constrain(goal, reduced, WHOLE, inset=AIM)
            self._items.extend(zip(constrain(goal, reduced, WHOLE), aims, strict=True))

    def __call__(self, begin: Floats) -> Projected:
        """Search from many starts.

        Damping in proportion to the squared error needs no trial steps and still converges
        quadratically. Source: Sugihara, Solvability-unconcerned inverse kinematics by the
        Levenberg-Marquardt method, IEEE T-RO 2011.

        Args:
            begin: Shape (S, n) [rad | m].
        """
        limits = self._limits
        positions = np.clip(begin, limits.lower, limits.upper)
        violation = np.full(len(begin), np.inf)
        searching = np.arange(len(begin))
        for count in range(STEPS + 1):
            at = self._linearise(positions[searching])
            violation[searching] = at.violation
            going = at.violation > 0.0
            searching = searching[going]
            if count == STEPS or len(searching) == 0:
                break
            now = positions[searching]
            step = self._step(now, at.error[going], at.jacobian[going])
            positions[searching] = np.clip(now + step, limits.lower, limits.upper)
        return Projected(positions, violation)

    def violation(self, positions: Floats) -> Floats:
        """Return how far configurations of shape (S, n) are from holding the requirements, (S,)."""
        return self._linearise(positions).violation

    def _step(self, positions: Floats, error: Floats, jacobian: Floats) -> Floats:
        """Solve the damped normal equations; joints that press against a limit stay."""
        n = positions.shape[1]
        transposed = np.swapaxes(jacobian, 1, 2)
        slope = (transposed @ error[:, :, None])[:, :, 0]
        damping = 0.5 * np.einsum("sd,sd->s", error, error) + LEAST_DAMPING
        free = ~self._pressed(positions, slope)
        normal = (transposed @ jacobian) * (free[:, :, None] & free[:, None, :])
        normal += damping[:, None, None] * np.eye(n)
        return -np.linalg.solve(normal, (slope * free)[:, :, None])[:, :, 0]

    def _pressed(self, positions: Floats, slope: Floats) -> Bools:
        limits = self._limits
        return ((positions <= limits.lower) & (slope > 0.0)) | ((positions >= limits.upper) & (slope < 0.0))

    def _linearise(self, positions: Floats) -> _Linearised:
        motion = Motion.each(positions, self._query)
        samples, n = positions.shape
        errors, jacobians = [np.empty((samples, 0))], [np.empty((samples, 0, n))]
        violation = np.zeros(samples)
        for accepted, aim in self._items:
            rows = accepted.residual.linearise(motion)
            value = rows.value.reshape(samples, -1)
            outside = np.maximum(accepted.lower - value, value - accepted.upper).max(axis=1)
            violation += np.where(outside > accepted.tolerance, outside, 0.0)
            narrow = aim.upper - aim.lower <= NARROW
            middle = np.where(narrow, 0.5 * (aim.lower + aim.upper), 0.0)
            error = np.where(narrow, value - middle, value - np.clip(value, aim.lower, aim.upper))
            matters = narrow | (error != 0.0)
            errors.append(error)
            jacobians.append(rows.jacobian[:, 0].reshape(samples, -1, n) * matters[:, :, None])
        return _Linearised(np.concatenate(errors, axis=1), np.concatenate(jacobians, axis=1), violation)
