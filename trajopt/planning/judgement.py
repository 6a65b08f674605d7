"""judge(problem, trajectory): any trajectory, checked against all that a problem requires."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trajopt.geometry import Evaluator, evaluator
from trajopt.problem.motion import Motion
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import During, Requirement
from trajopt.problem.residual import END, Constraint
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Printed, one_of
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Certificate, Judge, Specification, Verdict


@dataclass(frozen=True, eq=False)
class Along:
    """A constraint as something that can be evaluated at sampled times."""

    item: Constraint
    query: Evaluator

    @property
    def name(self) -> str:
        return self.item.residual.name

    def evaluate(self, times: Floats, positions: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the violation at times (s,) and positions (s, n), and its bounds, -inf and the tolerance."""
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


def judged(items: tuple[Constraint, ...], reduced: ReducedModel) -> tuple[Along, ...]:
    if not items:
        return ()
    query = evaluator(reduced)
    return tuple(Along(item, query) for item in items)


@dataclass(frozen=True, eq=False)
class Judged(Printed):
    """A judged motion.

    Attributes:
        verified: Whether all requirements of the problem are proven.
        known: Its certificate, if measured already, as for a refused motion.
    """

    problem: Problem
    trajectory: Trajectory
    verified: bool
    known: Certificate | None = None

    @cached_property
    def certificate(self) -> Certificate:
        """The checks with their margins and proofs; measured on first use, since planning only decides."""
        return self.known or judge(self.problem, self.trajectory)


@checked
def judge(problem: Problem, trajectory: Trajectory, *, workspace: Judge | None = None) -> Certificate:
    """Judge a motion by all requirements of a problem.

    Args:
        problem: With one goal.
        trajectory: Of the group's joints.
        workspace: The judge of the problem's reduced model; a new one when None.

    Raises:
        ProblemError: If the trajectory is of other joints than the group's, the goal is a set, or an argument
            is of the wrong kind.
    """
    judging = workspace or Judge(one_of("problem", problem, Problem).reduced)
    return judging.certify(trajectory, _specification(problem))


def holds(problem: Problem, trajectory: Trajectory, workspace: Judge) -> Verdict:
    return workspace.decide(trajectory, _specification(problem))


def decide(problem: Problem, trajectory: Trajectory, workspace: Judge) -> tuple[Judged, int]:
    """Decide as `judge` does, without measuring more.

    Returns:
        The verdict, with the certificate if it is a refusal, and the number of distances measured.
    """
    specification = _specification(problem)
    verdict = workspace.decide(trajectory, specification)
    if verdict.verified:
        return Judged(problem, trajectory, verified=True), verdict.counts.distances
    certificate = workspace.certify(trajectory, specification)
    count = verdict.counts.distances + certificate.counts.distances
    return Judged(problem, trajectory, certificate.verified, certificate), count


def _specification(problem: Problem) -> Specification:
    return Specification(
        goals=problem.goals,
        constraints=problem.requirements,
        waypoints=dict(zip(problem.waypoint_names, problem.waypoint_requirements, strict=True)),
        partial=_partial(problem),
        sampled=judged(problem.residual_constraints, problem.reduced),
        limits=problem.moving_limits,
        tool_speeds=problem.tool_speeds,
        start_velocities=problem.start_velocities,
        start_accelerations=problem.start_accelerations,
        dwell=problem.dwell,
        finish_by=problem.finish_by,
    )


def _partial(problem: Problem) -> list[During[Requirement] | During[Along]]:
    found: list[During[Requirement] | During[Along]] = []
    for part in problem.partial:
        asked = part.required
        if isinstance(asked, Constraint):
            found.append(During(Along(asked, evaluator(problem.reduced)), part.after, part.until))
        else:
            found.append(During(asked, part.after, part.until))
    return found
