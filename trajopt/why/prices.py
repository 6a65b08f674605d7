"""Prices of active constraints, in units of the objective and in seconds."""

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeVar

import numpy as np

from trajopt.optimise.kinematics.projection import Projection
from trajopt.optimise.methods.timing import retime_path
from trajopt.optimise.nlp import Linearisation
from trajopt.optimise.solvers import Sqp
from trajopt.optimise.terms import Clearance, constrain
from trajopt.optimise.terms.gravity_torque import HoldingTorque
from trajopt.optimise.transcription import KnotsNlp, transcribe
from trajopt.planning.result import Result
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import DEGREES, MILLIMETRES, PLAIN, Requirement
from trajopt.problem.requirements.joints import SHARE
from trajopt.problem.residual import WHOLE
from trajopt.robot.joints import LimitKind
from trajopt.timing import Retimed
from trajopt.values.arrays import Floats, Loss, Rows
from trajopt.values.trajectory import Path
from trajopt.why.change import smaller_clearance, smaller_margin, with_requirement

ACTIVE = 2e-3
"""A row is active if it is within this distance of its bound, in its own unit."""


class RowKey(NamedTuple):
    """Identifies the rows of a linearisation that belong together."""

    kind: type[object]
    name: str
    component: int


@dataclass(frozen=True, eq=False)
class Multipliers:
    """Lagrange multipliers of each constraint's active rows.

    Attributes:
        rows: By class and name of the residual and component of the row: decrease of the cost per unit that
            the bounds of all such rows are moved outward.
        bounds: Likewise for the bounds of each variable, by its index in a knot, over all knots.
        unbalanced: Share of the gradient that the active rows do not balance: 0 at a perfect solution.
    """

    rows: dict[RowKey, float]
    bounds: dict[int, float]
    unbalanced: float


def multipliers(at: Linearisation, lower: Floats, upper: Floats) -> Multipliers:
    """Balance the gradient of the costs with the active rows and bounds.

    Source: Nocedal and Wright, Numerical Optimization, 2nd edition, section 12.3.

    Args:
        lower: Lower bounds of the knots, shape (N, n); equal to the upper for a fixed knot.
        upper: Upper bounds, shape (N, n).
    """
    size, free = at.x.size, (lower < upper).ravel()
    gradient = np.zeros(size)
    for cost in at.costs:
        value, weight = cost.rows.value, cost.weight
        slope = {
            Loss.SQUARED: 2.0 * value,
            Loss.ABSOLUTE: np.sign(value),
            Loss.HINGE: (value > 0.0) * 1.0,
        }[cost.loss]
        gradient += (weight * slope) @ _dense(cost.rows, size)
    columns: list[Floats] = []
    owners: list[RowKey] = []
    for block in at.constraints:
        jacobian = _dense(block.rows, size)
        for sign, side in ((1.0, block.upper), (-1.0, block.lower)):
            for row in np.flatnonzero(sign * (side - block.rows.value) <= ACTIVE).tolist():
                columns.append(sign * jacobian[row])
                owners.append(RowKey(block.kind, block.name, int(block.rows.component[row])))
    count = len(columns)
    places: list[int] = []
    for sign, side in ((1.0, upper), (-1.0, lower)):
        for place in np.flatnonzero(free & (sign * (side - at.x).ravel() <= ACTIVE)).tolist():
            columns.append(sign * np.eye(1, size, place)[0])
            places.append(place % at.x.shape[1])
    scale = float(np.linalg.norm(gradient[free]))
    if not columns:
        return Multipliers({}, {}, 1.0 if scale > 0.0 else 0.0)
    from scipy.optimize import nnls

    try:
        push, missing = nnls(np.array(columns).T[free], -gradient[free])
    except RuntimeError:  # it did not end: columns that are nearly the same let it go round in circles
        return Multipliers({}, {}, 1.0)
    return Multipliers(
        _summed(owners, push[:count]),
        _summed(places, push[count:]),
        float(missing) / scale if scale > 0.0 else 0.0,
    )


Key = TypeVar("Key", bound=Hashable)


def _summed(keys: Sequence[Key], push: Floats) -> dict[Key, float]:
    total: dict[Key, float] = {}
    for key, force in zip(keys, push.tolist(), strict=True):
        total[key] = total.get(key, 0.0) + force
    return total


def _dense(rows: Rows, size: int) -> Floats:
    """Scatter block rows into a matrix over all variables, shape (m, size)."""
    m, k, n = rows.jacobian.shape
    dense = np.zeros((m, size // n, n))
    every = np.arange(m, dtype=np.int64)
    for place in range(k):
        np.add.at(dense, (every, rows.knots[:, place]), rows.jacobian[:, place])
    return dense.reshape(m, size)


TIGHT = Sqp(max_iterations=300, relative_gain=1e-7, absolute_gain=1e-10)
"""Prices are differences of costs, so the solver must not stop early."""
UNBALANCED = 0.2
"""Multipliers that leave more of the gradient than this share are not reported."""
LEAST = 1e-3
"""Objective prices below this share of the largest are left out."""
STEP = 2.0
"""Relaxation of a constraint for its price in seconds [mm | deg]."""
PERCENT = 5.0
"""Increase of a joint's limit for its price in seconds [%]."""
TOLERANCE = 1e-3
"""Largest deviation of the timed motion from the path [m]."""
LEAST_SECONDS = 1e-4
"""Smaller changes of the duration are numerical noise [s]."""


@dataclass(frozen=True, kw_only=True)
class Price:
    """Price of an active constraint.

    Attributes:
        unit: "mm", "deg", "rad" or "%": the unit of relaxation.
        objective: Decrease of the objective per unit; None for limits that the objective does not contain.
        seconds: Decrease of the duration [s]; None if not requested or unknown.
    """

    what: str
    unit: str
    objective: float | None
    seconds: float | None

    def as_dict(self) -> dict[str, object]:
        """Return plain JSON data."""
        return {"what": self.what, "unit": self.unit, "objective": self.objective, "seconds": self.seconds}

    def __str__(self) -> str:
        parts = [] if self.seconds is None else [f"{1000 * self.seconds:.3g} ms of the motion"]
        parts += [] if self.objective is None else [f"{self.objective:.3g} of the optimiser's objective"]
        return f"{self.what}: {' and '.join(parts)} per {self.unit}"


def prices(result: Result, *, seconds: bool = False) -> tuple[Price, ...]:
    """Return the prices of a verified motion's active constraints, the largest first.

    The motion's own program is solved again, tightly; prices in seconds compare the timed motions of that
    solution and of one with a slightly relaxed constraint.

    Args:
        result: Of the method `Knots`; others have no prices.
        seconds: Whether to solve and time relaxed problems too.
    """
    if not result.verified or result.path is None or result.timed is None:
        return ()
    if len(result.path.knots) != result.problem.knots:
        return ()  # it followed a curve, along more knots than the program of a problem has
    return path_prices(result.problem, result.path.knots, seconds=seconds)


def path_prices(problem: Problem, knots: Floats, *, seconds: bool) -> tuple[Price, ...]:
    """Return the prices of a path's active constraints, the largest first; as `prices`.

    Args:
        knots: The path of a verified motion, shape (K, n) [rad | m].
    """
    base = _Solved.of(problem, knots)
    at = base.multipliers
    if at.unbalanced > UNBALANCED or not base.holds:
        return _limits(base) if seconds else ()
    largest = max((*at.rows.values(), *at.bounds.values()), default=0.0)
    dear = {key: value for key, value in at.rows.items() if value > LEAST * largest}
    found = [*_clearances(base, dear, seconds), *_requirements(base, dear, seconds)]
    found += _holding(base, dear, seconds)
    found += _bounds(
        base, {key: value for key, value in at.bounds.items() if value > LEAST * largest}, seconds
    )
    found.sort(key=lambda price: -(price.objective or 0.0))
    return (*found, *(_limits(base) if seconds else ()))


@dataclass(frozen=True, eq=False)
class _Solved:
    """A problem's program, solved tightly from given knots."""

    problem: Problem
    nlp: KnotsNlp
    knots: Floats
    holds: bool
    multipliers: Multipliers

    @staticmethod
    def of(problem: Problem, knots: Floats) -> "_Solved":
        nlp = transcribe(problem, knots, _waypoint_knots(problem, knots))
        solved = TIGHT.solve(nlp, knots)
        at = multipliers(solved.at, nlp.lower, nlp.upper)
        return _Solved(problem, nlp, solved.x, solved.feasible, at)

    def duration(self, problem: Problem | None = None) -> float | None:
        path = Path(self.problem.reduced.joint_names, self.knots)
        motion = retime_path(problem or self.problem, path, tolerance=TOLERANCE, query=self.nlp.query)
        return motion.trajectory.duration if isinstance(motion, Retimed) else None

    def saved(self, relaxed: Problem, amount: float) -> float | None:
        again = _Solved.of(relaxed, self.knots)
        before, after = self.duration(), again.duration() if again.holds else None
        return None if before is None or after is None else (before - after) / amount


def _waypoint_knots(problem: Problem, knots: Floats) -> list[int]:
    places: list[int] = []
    count = len(problem.waypoint_requirements)
    for number, wanted in enumerate(problem.waypoint_requirements):
        first = places[-1] + 1 if places else 1
        last = len(knots) - 1 - (count - 1 - number)
        off = Projection(problem.reduced, wanted, problem.evaluator(problem.reduced)).violation(
            knots[first:last]
        )
        places.append(first + int(np.argmin(off)))
    return places


def _clearances(base: _Solved, dear: dict[RowKey, float], seconds: bool) -> Iterator[Price]:
    reduced, total = base.problem.reduced, dict[tuple[str, str], float]()
    for key, push in dear.items():
        if key.kind is Clearance:
            owners = reduced.owners(key.component)
            total[owners] = total.get(owners, 0.0) + push
    for (first, second), push in total.items():
        binding = (first, second, STEP * MILLIMETRES.size)
        change = smaller_margin(base.problem, *binding) or smaller_clearance(base.problem, *binding)
        step = 0.0 if change is None else min(STEP * MILLIMETRES.size, change.largest)
        yield Price(
            what=f"clearance of {first} from {second}" if change is None else change.what,
            unit="mm",
            objective=push * MILLIMETRES.size,
            seconds=base.saved(change.apply(step), step / MILLIMETRES.size) if change and seconds else None,
        )


def _holding(base: _Solved, dear: dict[RowKey, float], seconds: bool) -> Iterator[Price]:
    """Yield the prices of holding the load still: the joints' shares fall as their limits rise."""
    names, total = base.problem.reduced.joint_names, dict[str, float]()
    for key, push in dear.items():
        if key.kind is HoldingTorque:
            joint = names[key.component]
            total[joint] = total.get(joint, 0.0) + push
    for joint, push in total.items():
        relaxed = _with_limits(base.problem, [joint], "effort", PERCENT / 100.0) if seconds else None
        yield Price(
            what=f"effort limit of {joint}, to hold still",
            unit="%",
            objective=push * SHARE / 100.0,
            seconds=None if relaxed is None else base.saved(relaxed, PERCENT),
        )


def _requirements(base: _Solved, dear: dict[RowKey, float], seconds: bool) -> Iterator[Price]:
    problem = base.problem
    for required in problem.all_requirements:
        residuals = [item.residual for item in constrain(required, problem.reduced, WHOLE)]
        mine = {(type(residual), residual.name) for residual in residuals}
        push = sum(value for key, value in dear.items() if (key.kind, key.name) in mine)
        if push == 0.0:
            continue
        unit = next((way.unit for way in required.relaxations), PLAIN)
        yield Price(
            what=", ".join(sorted({residual.name for residual in residuals})),
            unit=unit.name or "unit",
            objective=push * unit.size,
            seconds=_saved_by(base, required) if seconds else None,
        )


def _saved_by(base: _Solved, required: Requirement) -> float | None:
    for way in required.relaxations[:1]:
        amount = min(STEP * way.unit.size, way.largest)
        relaxed = with_requirement(base.problem, required, way.apply(amount))
        return base.saved(relaxed, amount / way.unit.size)
    return None


def _bounds(base: _Solved, dear: dict[int, float], seconds: bool) -> Iterator[Price]:
    reduced = base.problem.reduced
    for place, push in dear.items():
        name = reduced.joint_names[place]
        sides = (LimitKind.LOWER, LimitKind.UPPER)
        binding = reduced.limits.binding
        limited = [name, *(binding[name, side] for side in sides if (name, side) in binding)]
        relaxed = _with_limits(base.problem, limited, "position", STEP * DEGREES.size) if seconds else None
        yield Price(
            what=f"position limit of {name}{reduced.limits.because(name, *sides)}",
            unit="deg",
            objective=push * DEGREES.size,
            seconds=None if relaxed is None else base.saved(relaxed, STEP),
        )


def _limits(base: _Solved) -> tuple[Price, ...]:
    """Return the prices of binding limits: the path is timed with each limit slightly higher."""
    before, found = base.duration(), list[Price]()
    if before is None:
        return ()
    for kind in ("velocity", "acceleration", "jerk", "effort"):
        everyone = base.problem.reduced.moving_joints
        if not _gain(base, before, everyone, kind) > LEAST_SECONDS:
            continue
        for name in everyone:
            gain = _gain(base, before, [name], kind)
            if gain > LEAST_SECONDS:
                what = f"{kind} limit of {name}"
                found.append(Price(what=what, unit="%", objective=None, seconds=gain / PERCENT))
    return tuple(sorted(found, key=lambda price: -(price.seconds or 0.0)))


def _gain(base: _Solved, before: float, joints: Sequence[str], kind: str) -> float:
    after = base.duration(_with_limits(base.problem, joints, kind, PERCENT / 100.0))
    return 0.0 if after is None else before - after


def _with_limits(problem: Problem, joints: Sequence[str], kind: str, amount: float) -> Problem:
    """Return the problem with a limit of joints raised: by a share, or positions by an amount [rad | m]."""
    robot = problem.scene.robot
    index, limits = robot.index(joints), robot.limits
    if kind == "position":
        lower, upper = np.array(limits.lower), np.array(limits.upper)
        lower[index] -= amount
        upper[index] += amount
        raised = replace(limits, lower=lower, upper=upper)
    else:
        values = np.array(getattr(limits, kind))
        values[index] *= 1.0 + amount
        raised = replace(limits, **{kind: values})
    return replace(problem, scene=replace(problem.scene, robot=replace(robot, limits=raised)))
