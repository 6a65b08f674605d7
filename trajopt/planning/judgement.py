"""judge(problem, trajectory): all that a problem asks, put to the judge; anybody's motion will do."""

from trajopt.model.requirements import During, Requirement
from trajopt.model.trajectory import Trajectory
from trajopt.problem import Problem
from trajopt.query import Query
from trajopt.terms import Constraint
from trajopt.terms.along import Along, judged
from trajopt.verify import Certificate, Judge


def judge(problem: Problem, trajectory: Trajectory, *, workspace: Judge | None = None) -> Certificate:
    """Judge a motion by all that a problem asks, with nothing of what its planner made but the motion.

    Args:
        problem: The problem, with one goal.
        trajectory: Of the group's joints.
        workspace: The judge of the problem's reduced model; a new one when None.

    Raises:
        ProblemError: If the trajectory is of other joints than the group's, or the goal is a set.
    """
    return (workspace or Judge(problem.reduced)).verify(
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
