"""Projection of configurations onto requirements: Levenberg-Marquardt on a batch of starts."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.geometry import Evaluator
from trajopt.optimise.terms import Constraint, constrain
from trajopt.optimise.terms.joint_positions import without_followers
from trajopt.optimise.terms.requirement import INSET
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import Requirement, together
from trajopt.problem.residual import WHOLE
from trajopt.robot.joints import JointLimits
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Bools, Floats

STEPS = 12
"""Steps from each start; three more find a twentieth more solutions."""
MOST_STEPS = 40
"""Steps while no start has led to a solution."""


@dataclass(frozen=True)
class Aim:
    """Where within its bounds a component is sought.

    Attributes:
        inset: Share of each tolerance kept in reserve.
        least: Share of it that a solution keeps.
        narrow: Components with nearer bounds than this aim at the middle [m | rad].
    """

    inset: float
    least: float
    narrow: float


INSIDE = Aim(0.2, INSET, 1e-2)
"""Leaves the optimiser and rounding a reserve."""
ANYWHERE = Aim(0.01, 0.0, 1e-3)
"""For requirements that hold together only near their bounds."""
DAMPING = 0.03
"""Damping by squared error; 0.01 to 0.1 find as much, 0.5 and 0.001 a third less."""
LEAST_DAMPING = 1e-8
"""Damping when nothing is violated; keeps the normal equations regular."""
GAP = 0.1
"""Joints whose range lacks at most this of a full turn pass from one limit to the other [rad]."""


def turning_joints(reduced: ReducedModel) -> Floats:
    """Return 1 for each joint of the group that turns and 0 for each that slides, shape (n,)."""
    joints = (reduced.model.joints[reduced.model.getJointId(name)] for name in reduced.joint_names)
    return np.array(["JointModelR" in joint.shortname() for joint in joints], dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Projected:
    """Result of a search.

    Attributes:
        positions: Shape (S, n) [rad | m], inside the limits.
        violation: At each, shape (S,) [m and rad]; 0 if the requirements hold.
    """

    positions: Floats
    violation: Floats


@dataclass(frozen=True, eq=False)
class _Linearised:
    """Requirements at S configurations.

    Attributes:
        error: Residual to bring to zero, shape (S, d).
        jacobian: Its derivative, shape (S, d, n); zero in rows within their bounds.
        violation: Shape (S,).
    """

    error: Floats
    jacobian: Floats
    violation: Floats


@dataclass(frozen=True, eq=False)
class _Asked:
    """Bounds of a residual's components, shape (d,), or (1,) if all have the same; `upper` is an aim."""

    accepted: Constraint
    lower: Floats
    upper: Floats

    @staticmethod
    def of(accepted: Constraint, sought: Constraint, width: float) -> "_Asked":
        narrow = sought.upper - sought.lower <= width
        half = 0.5 * (sought.upper - sought.lower)[narrow]
        lower, upper = sought.lower.copy(), sought.upper.copy()
        lower[narrow] += half
        upper[narrow] = lower[narrow]
        return _Asked(accepted, lower, upper)

    def linearise(self, motion: Motion) -> _Linearised:
        rows = self.accepted.residual.linearise(motion)
        samples, n = motion.positions.shape
        sample, component = rows.knots[:, 0], rows.component
        lowest, highest = self.accepted.bounds(rows)
        outside = np.zeros(samples)
        np.maximum.at(outside, sample, np.maximum(lowest - rows.value, rows.value - highest))
        lower, upper = (side[component] if len(side) > 1 else side for side in (self.lower, self.upper))
        size = int(component.max(initial=-1)) + 1
        error, jacobian = np.zeros((samples, size)), np.zeros((samples, size, n))
        missed = rows.value - np.clip(rows.value, lower, upper)
        matters = (missed != 0.0) | (lower == upper)
        error[sample, component] = missed
        jacobian[sample, component] = rows.jacobian[:, 0] * matters[:, None]
        return _Linearised(error, jacobian, np.where(outside > self.accepted.tolerance, outside, 0.0))


class Projection:
    """Moves configurations until they hold requirements."""

    def __init__(
        self, reduced: ReducedModel, goals: Sequence[Requirement], query: Evaluator, aim: Aim = INSIDE
    ) -> None:
        self.reduced, self.goals = reduced, tuple(goals)
        self._query = query
        self._limits: JointLimits = reduced.limits
        self._turn = 2.0 * np.pi * turning_joints(reduced)
        span = reduced.limits.upper - reduced.limits.lower
        self._passes = (self._turn > 0.0) & (span > 2.0 * np.pi - GAP)
        self._asked = [
            _Asked.of(accepted, sought, aim.narrow)
            for goal in together(without_followers(goals, reduced))
            for accepted, sought in zip(
                constrain(goal, reduced, WHOLE, inset=aim.least),
                constrain(goal, reduced, WHOLE, inset=aim.inset),
                strict=True,
            )
        ]

    def __call__(self, begin: Floats) -> Projected:
        """Search from many starts, shape (S, n) [rad | m].

        Damping by squared error: Sugihara, Solvability-unconcerned inverse kinematics by the
        Levenberg-Marquardt method, IEEE T-RO 2011.
        """
        limits = self._limits
        positions = np.clip(begin, limits.lower, limits.upper)
        violation = np.full(len(begin), np.inf)
        searching = np.arange(len(begin))
        for count in range(MOST_STEPS + 1):
            at = self._linearise(positions[searching])
            violation[searching] = at.violation
            going = at.violation > 0.0
            searching = searching[going]
            enough = count >= STEPS and len(searching) < len(begin)
            if enough or count == MOST_STEPS or len(searching) == 0:
                break
            now = positions[searching]
            step = self._step(now, at.error[going], at.jacobian[going])
            positions[searching] = self._inside(now + step)
        return Projected(positions, violation)

    def measure(self, positions: Floats) -> Projected:
        """Move configurations (S, n) of another search into the limits and measure the violation."""
        inside = np.clip(positions, self._limits.lower, self._limits.upper)
        return Projected(inside, self.violation(inside))

    def violation(self, positions: Floats) -> Floats:
        """Return the violation at configurations of shape (S, n), shape (S,)."""
        return self._linearise(positions).violation

    def jacobian(self, positions: Floats) -> Floats:
        """Return derivatives of the requirements, (S, n) -> (S, d, n); zero in rows within their bounds."""
        return self._linearise(positions).jacobian

    def _step(self, positions: Floats, error: Floats, jacobian: Floats) -> Floats:
        """Solve the damped normal equations; joints that press against a limit stay."""
        n = positions.shape[1]
        transposed = np.swapaxes(jacobian, 1, 2)
        slope = (transposed @ error[:, :, None])[:, :, 0]
        # No rotation errs by more; a position that does by 100 m needs no steps of centimetres.
        counted = np.clip(error, -np.pi, np.pi)
        damping = DAMPING * np.einsum("sd,sd->s", counted, counted) + LEAST_DAMPING
        free = ~self._pressed(positions, slope)
        normal: Floats = np.where(free[:, :, None] & free[:, None, :], transposed @ jacobian, 0.0)
        normal += damping[:, None, None] * np.eye(n)
        downhill: Floats = np.where(free, -slope, 0.0)
        return np.asarray(np.linalg.solve(normal, downhill[:, :, None])[:, :, 0], dtype=np.float64)

    def _inside(self, positions: Floats) -> Floats:
        limits = self._limits
        beyond = (positions > limits.upper) * 1.0 - (positions < limits.lower)
        turned = np.where(self._passes, positions - beyond * self._turn, positions)
        return np.clip(turned, limits.lower, limits.upper)

    def _pressed(self, positions: Floats, slope: Floats) -> Bools:
        limits = self._limits
        low, high = positions <= limits.lower, positions >= limits.upper
        return ~self._passes & ((low & (slope > 0.0)) | (high & (slope < 0.0)))

    def _linearise(self, positions: Floats) -> _Linearised:
        motion = Motion.each(positions, self._query)
        samples, n = positions.shape
        errors, jacobians, violation = (
            [np.empty((samples, 0))],
            [np.empty((samples, 0, n))],
            np.zeros(samples),
        )
        for asked in self._asked:
            part = asked.linearise(motion)
            errors.append(part.error)
            jacobians.append(part.jacobian)
            violation += part.violation
        return _Linearised(np.concatenate(errors, axis=1), np.concatenate(jacobians, axis=1), violation)
