"""Branches: the goal configurations that a motion may end at, with what was transcribed for each."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from trajopt.optimise.methods import Method, Program
from trajopt.optimise.terms import Acceleration, Jerk, Velocity
from trajopt.optimise.transcription import fixed_goal
from trajopt.planning.schedule import NEAREST
from trajopt.planning.seeds import Blocked, SeedContext, SeedKind, WaypointLine, line_through
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import joint_positions
from trajopt.values.arrays import Floats, Value


@dataclass(eq=False)
class GoalBranch(Value):
    """One end that a motion may have.

    Attributes:
        kind: Kind of its straight line.
        problem: The problem, with the goal that it is to end at.
        line: Straight legs there.
        method: Transcribes the problem.
        blocked: Where its straight line ended against something.
    """

    kind: SeedKind
    problem: Problem
    line: WaypointLine
    method: Method
    blocked: tuple[Blocked, ...] = ()

    @cached_property
    def program(self) -> Program:
        """The transcribed problem; owns a query, so one in each thread."""
        return self.method.program(self.problem, self.line.knots, self.line.places)

    @cached_property
    def context(self) -> SeedContext:
        """What sources of seeds need to know."""
        return SeedContext(self.problem.reduced, self.line, self.program.scale, self.problem.requirements)


def branches(problem: Problem, stops: Sequence[Sequence[Floats]], method: Method) -> Iterator[GoalBranch]:
    """Yield the ends that a motion may have, nearest first.

    Where goal configurations were searched for, the program first gets each of them as it is, and only then
    the nearest with the freedom to choose another: that is harder to solve.

    Args:
        problem: The problem, with one goal.
        stops: For each goal configuration, nearest first: those of the waypoints, and it.
        method: Transcribes the problem.
    """
    reduced, pinned = problem.reduced, fixed_goal(problem)
    chosen = pinned is None and _end_is_free(problem)
    for number, way in enumerate(stops):
        kind = SeedKind.BRANCH if number else SeedKind.STRAIGHT
        line = line_through(reduced, (reduced.start_positions, *way), problem.knots)
        there = pinned is None or np.array_equal(way[-1], pinned)
        asked = problem if there and not chosen else _ending_at(problem, way[-1])
        yield GoalBranch(kind, asked, line, method)
        if chosen and number == min(NEAREST, len(stops)) - 1:
            nearest = line_through(reduced, (reduced.start_positions, *stops[0]), problem.knots)
            yield GoalBranch(SeedKind.FREE_END, problem, nearest, method)


def _end_is_free(problem: Problem) -> bool:
    """Whether any configuration that holds the goals will do, so that only the program can find more."""
    known = (Velocity, Acceleration, Jerk)
    return not problem.residual_constraints and all(
        isinstance(cost.residual, known) for cost in problem.costs or ()
    )


def _ending_at(problem: Problem, positions: Floats) -> Problem:
    """Return the problem with a configuration of the group as its goal."""
    goal = joint_positions(dict(zip(problem.reduced.joint_names, positions.tolist(), strict=True)))
    return replace(problem, goal=goal)
