"""What a problem asks at its ends and on its way, as plain data; constraints in user code are left out."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain

from trajopt.errors import ProblemError
from trajopt.model.requirements import During, GoalSet, Requirement
from trajopt.problem import Problem


def always_at_start(problem: Problem) -> tuple[Requirement, ...]:
    """Return the path constraints that hold at the start."""
    return problem.requirements_at(0)


def always_at_end(problem: Problem) -> tuple[Requirement, ...]:
    """Return the path constraints that hold at the end."""
    return problem.requirements_at(1 + len(problem.waypoint_names))


def everything(problem: Problem) -> tuple[Requirement, ...]:
    """Return path constraints, those of a part of the way, goals and waypoints."""
    partial = (item.required for item in problem.partial if isinstance(item.required, Requirement))
    return (*problem.requirements, *partial, *problem.goals, *chain(*problem.waypoint_requirements))


def with_requirement(problem: Problem, old: Requirement, new: Requirement) -> Problem:
    """Return the problem with one requirement in place of another, wherever it is asked.

    Raises:
        ProblemError: If the problem has a set of goals.
    """
    if isinstance(problem.goal, GoalSet):
        raise ProblemError("the goal is a set: ask one of the problem's alternatives")

    def swapped(items: Sequence[Requirement]) -> tuple[Requirement, ...]:
        return tuple(new if item is old else item for item in items)

    return replace(
        problem,
        goal=swapped(problem.goals),
        waypoints={
            name: swapped(items)
            for name, items in zip(problem.waypoint_names, problem.waypoint_requirements, strict=True)
        },
        constraints=tuple(
            During(new, item.after, item.until)
            if isinstance(item, During) and item.required is old
            else new
            if item is old
            else item
            for item in problem.constraints
        ),
    )
