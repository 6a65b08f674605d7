"""Goals of which any one will do: the planner chooses, and says which."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from trajopt.arrays import mapping, several
from trajopt.errors import ProblemError, shown
from trajopt.model.requirements.requirement import Requirement


@dataclass(frozen=True, eq=False)
class GoalSet:
    """Several goals by name, each one requirement or several.

    Attributes:
        alternatives: What must hold at the end, by the name of the goal.
    """

    alternatives: Mapping[str, tuple[Requirement, ...]]

    def __str__(self) -> str:
        """Name the goals."""
        return f"any of {', '.join(self.alternatives)}"


def any_of(goals: Mapping[str, Requirement | Sequence[Requirement]]) -> GoalSet:
    """Accept any one of several goals, such as the grasps of an object.

    The planner tries the one that is nearest first; `Result.goal_name` says which it reached.

    Args:
        goals: Requirements, one or several that hold together, by name.

    Raises:
        ProblemError: If there is none, or one of them requires nothing.
    """
    alternatives: dict[str, tuple[Requirement, ...]] = {}
    for name, goal in mapping("any_of: goals", goals).items():
        several_held = (goal,) if isinstance(goal, Requirement) else goal
        alternatives[name] = several(f"goal {shown(name)}", several_held, Requirement)
        if not alternatives[name]:
            raise ProblemError(f"goal {shown(name)} requires nothing")
    if not alternatives:
        raise ProblemError("a goal set needs at least one goal")
    return GoalSet(alternatives)
