"""judge(problem, trajectory): any trajectory, checked against all that a problem requires."""

from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats, one_of
from trajopt.model.requirements import During, Requirement
from trajopt.model.trajectory import Trajectory
from trajopt.problem import Problem
from trajopt.query import Query
from trajopt.terms.motion import Motion
from trajopt.terms.residual import END, Constraint
from trajopt.verify import Certificate, Judge


@dataclass(frozen=True, eq=False)
class Along:
    """A constraint as something that can be evaluated at sampled times.

    Attributes:
        item: The constraint.
        query: Evaluates kinematics.
    """

    item: Constraint
    query: Query

    @property
    def name(self) -> str:
        """Name of the residual."""
        return self.item.residual.name

    def evaluate(self, times: Floats, positions: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the violation at each time, and its bounds.

        Args:
            times: Shape (s,) [s].
            positions: The group's, shape (s, n) [rad | m].

        Returns:
            Violation beyond the constraint's bounds, shape (s,), in the residual's unit, the lower
            bound -inf, and the upper bound: the constraint's tolerance.
        """
        count = len(times)
        segment = np.minimum(np.arange(count), count - 2)
        fraction = (np.arange(count) - segment).astype(np.float64)
        motion = Motion.between(positions, segment, fraction, self.query)
        if self.item.window == END:
            motion = motion.where(np.arange(count) == count - 1)
        rows = self.item.residual.linearise(motion)
        lower, upper = self.item.bounds(rows)
        worst = np.zeros(count)
        at = np.minimum(np.floor(rows.place + 1e-9).astype(np.int64), count - 1)
        np.maximum.at(worst, at, np.maximum(lower - rows.value, rows.value - upper))
        return worst, np.full(1, -np.inf), np.full(1, self.item.tolerance)


def judged(items: tuple[Constraint, ...], query: Query) -> tuple[Along, ...]:
    """Return the constraints as what the judge samples."""
    return tuple(Along(item, query) for item in items)


def judge(problem: Problem, trajectory: Trajectory, *, workspace: Judge | None = None) -> Certificate:
    """Judge a motion by everything that a problem requires; nothing else that its planner made is used.

    Args:
        problem: The problem, with one goal.
        trajectory: Of the group's joints.
        workspace: The judge of the problem's reduced model; a new one when None.

    Raises:
        ProblemError: If the trajectory is of other joints than the group's, the goal is a set, or an argument
            is of the wrong kind.
    """
    return (workspace or Judge(one_of("problem", problem, Problem).reduced)).verify(
        trajectory,
        goals=problem.goals,
        constraints=problem.requirements,
        waypoints=dict(zip(problem.waypoint_names, problem.waypoint_requirements, strict=True)),
        partial=_partial(problem),
        sampled=judged(problem.residual_constraints, Query(problem.reduced)),
        limits=problem.moving_limits,
        tool_speeds=problem.tool_speeds,
        start_velocities=problem.start_velocities,
    )


def _partial(problem: Problem) -> list[During[Requirement] | During[Along]]:
    query = Query(problem.reduced)
    found: list[During[Requirement] | During[Along]] = []
    for part in problem.partial:
        asked = part.required
        if isinstance(asked, Constraint):
            found.append(During(Along(asked, query), part.after, part.until))
        else:
            found.append(During(asked, part.after, part.until))
    return found
