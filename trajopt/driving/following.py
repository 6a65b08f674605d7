"""Following: a goal that moves while the robot drives to it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import TypeAlias, cast

from trajopt.driving.intention import Goal
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import Requirement, frame_placement
from trajopt.problem.stated import GoalLike
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Printed
from trajopt.values.placement import Placement
from trajopt.verify import Judge

GoalNow: TypeAlias = Callable[[], GoalLike | Sequence[GoalLike] | None]
"""Returns the goal as it is now, in any form that a problem takes; None where nobody knows."""


@dataclass(eq=False)
class Following(Printed):
    """A goal that moves while the robot drives to it.

    Attributes:
        goal: What is required on the way; the goal of its problem is where it was last.
        target: A frame of the scene that the group's tool goes to, or what returns the goal.
        offset: Where the tool goes as seen from the frame.
        tool: Which frame of the robot goes there.
        tolerance: By how much more than its own tolerances a goal may be missed before it is planned to anew
            [m | rad].
        hold: The goal is reached when it has held for so long while the robot stands [s].
        holds_since: Since when it has [s]; None while it does not.
        requested: The goal that a motion was asked to last, as the motion at hand misses it.
        again: When the last motion that was planned begins: to plan again before is no use [s].
    """

    goal: Goal
    target: str | GoalNow
    offset: Placement
    tool: str
    tolerance: float
    hold: float
    holds_since: float | None = None
    requested: Goal | None = None
    again: float = -inf
    _judge: tuple[Scene, Judge] | None = field(default=None, repr=False)

    def aimed(self, here: Problem) -> Problem:
        """Return the problem with the goal as it is.

        Args:
            here: With the scene as it is at the time of interest.

        Raises:
            FrameNotFound: If the frame is not in the scene.
            ProblemError: If what the function returns is no goal.
        """
        scene, problem = here.scene, self.goal.problem
        if isinstance(self.target, str):
            where = scene.placement_of(self.target, here.start_positions) * self.offset
            goal: object = frame_placement(self.tool, where)
        else:
            goal = self.target()
        if goal is not None:
            problem = replace(problem, goal=cast("GoalLike", goal), scene=scene)
            self.goal = replace(self.goal, problem=problem)
        return problem

    def holds(self, aimed: Problem, positions: Floats) -> bool:
        """Say whether a goal holds at positions of the group's joints, shape (n,), more or less."""
        scene = aimed.scene
        if self._judge is None or self._judge[0] is not scene:
            self._judge = scene, Judge(aimed.reduced)
        judge = self._judge[1]
        alternatives = list(aimed.alternatives.values()) or [aimed]
        return any(
            all(
                check.holds or not check.required
                for check in judge.check(positions, [_relaxed(goal, self.tolerance) for goal in each.goals])
            )
            for each in alternatives
        )


def _relaxed(goal: Requirement, by: float) -> Requirement:
    """Return a goal with all its tolerances larger by an amount [m | rad]."""
    for number in range(len(goal.relaxations)):
        goal = goal.relaxations[number].apply(by)
    return goal
