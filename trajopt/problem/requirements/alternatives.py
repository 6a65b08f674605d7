"""Goal sets: the planner chooses one goal and reports its name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from trajopt.problem.requirement import Requirement
from trajopt.robot.configuration import ConfigurationLike
from trajopt.values.arrays import mapping
from trajopt.values.errors import ProblemError, shown
from trajopt.values.placement import PlacementLike

GoalLike: TypeAlias = Requirement | ConfigurationLike | PlacementLike
"""A requirement; a configuration in any of its forms; or a placement of the group's tool frame in the
world.
"""


@dataclass(frozen=True, eq=False)
class GoalSet:
    """Several goals by name; a problem converts them to requirements."""

    alternatives: Mapping[str, GoalLike | Sequence[GoalLike]]

    def __str__(self) -> str:
        return f"any of {', '.join(self.alternatives)}"


def any_of(goals: Mapping[str, GoalLike | Sequence[GoalLike]]) -> GoalSet:
    """Accept any one of several goals, such as the grasps of an object.

    The planner tries the nearest first; `Result.goal_name` names the goal reached.

    Args:
        goals: Goals by name: one or several requirements that hold together; a configuration; a placement of
            the group's tool.

    Raises:
        ProblemError: If there are no goals, or one requires nothing.
    """
    for name, goal in mapping("any_of: goals", goals).items():
        if isinstance(goal, str | Sequence | Mapping) and len(goal) == 0:
            raise ProblemError(f"goal {shown(name)} requires nothing")
    if not goals:
        raise ProblemError("a goal set needs at least one goal")
    return GoalSet(dict(goals))
