"""Explanation: outcome, cause, evidence and remedies."""

from dataclasses import dataclass

from trajopt.optimise.kinematics.validity import missed_at
from trajopt.planning.infeasibility.reasons import Obstruction
from trajopt.planning.result import Attempt
from trajopt.planning.status import Certainty, OutcomeSummary, Status
from trajopt.problem.problem import Problem
from trajopt.robot.joints import joint_unit
from trajopt.values.arrays import Floats
from trajopt.values.printed import in_unit
from trajopt.values.trajectory import Path
from trajopt.why.change import Remedy, joint_moves
from trajopt.why.nearest import NearestFree
from trajopt.why.prices import Price

NAMED = 4
"""Number of obstacles that are named; the others are counted."""


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Explanation(OutcomeSummary):
    """Outcome and cause of planning: `print` it, or read its fields.

    Attributes:
        blocks: The obstacles, worst first.
        conflict: A minimal set of requirements that exclude each other: without any one of them the others
            can be met. Empty if no such set was found.
        configuration: The configuration that shows the cause, shape (n,) [rad | m]: the start or goal that is
            not free, the one nearest to the goal, or the worst contact on the path.
        nearest_free: The nearest free configuration, if relevant.
        path: The best path, if planning got that far.
        attempts: Outcome and obstacle of each seed.
        remedies: Changes that make it solvable; None if not searched.
        prices: Costs of active constraints; in seconds only if planned again.
    """

    problem: Problem
    blocks: tuple[Obstruction, ...] = ()
    conflict: tuple[str, ...] = ()
    configuration: Floats | None = None
    nearest_free: NearestFree | None = None
    path: Path | None = None
    attempts: tuple[Attempt, ...] = ()
    remedies: tuple[Remedy, ...] | None = None
    prices: tuple[Price, ...] = ()

    def as_dict(self) -> dict[str, object]:
        """Return plain data that JSON can hold."""
        return {
            **super().as_dict(),
            "blocks": [block.as_dict() for block in self.blocks],
            "conflict": list(self.conflict),
            "joint_names": list(self.problem.reduced.joint_names),
            "configuration": None if self.configuration is None else self.configuration.tolist(),
            "nearest_free": None if self.nearest_free is None else self.nearest_free.as_dict(),
            "tries": [each.as_dict() for each in self.attempts],
            "remedies": None if self.remedies is None else [each.as_dict() for each in self.remedies],
            "prices": [price.as_dict() for price in self.prices],
        }

    def __str__(self) -> str:
        lines = [super().__str__()]
        if self.conflict:
            found = "can be held" if self.certainty is Certainty.PROVEN else "was found to hold"
            lines.append(f"Nothing {found} all of these together; any one fewer can be held:")
            lines += [f"  {item}" for item in self.conflict]
        if self.blocks:
            lines.append("In the way:")
            lines += [f"  {block.words}" for block in self.blocks[:NAMED]]
            if len(self.blocks) > NAMED:
                lines.append(f"  and {len(self.blocks) - NAMED} more")
        if self.nearest_free is not None:
            lines.append(self._nearest(self.nearest_free))
        if self.remedies is not None and not self.remedies:
            lines.append("No single change of those that were tried makes it solvable.")
        if self.remedies:
            lines.append("Each of these makes it solvable, and half of it does not:")
            lines += [f"  {remedy}" for remedy in self.remedies]
        if self.prices:
            lines.append("What the active constraints cost, which would be saved if one gave way by a unit:")
            lines += [f"  {price}" for price in self.prices]
        return "\n".join(lines)

    def _nearest(self, free: NearestFree) -> str:
        problem, joints = self.problem, self.problem.reduced.joint_names
        units = [joint_unit(problem.scene.robot.model, joint) for joint in joints]
        weak = self.status in (Status.START_CANNOT_BE_HELD, Status.GOAL_CANNOT_BE_HELD)
        able = "can be held" if weak else "is free"
        if free.given > 0.0:
            where = ", ".join(in_unit(float(q), unit) for q, unit in zip(free.positions, units, strict=True))
            required = (*problem.goals, *problem.requirements_at(problem.last_stop))
            miss = missed_at(problem.reduced, required, free.positions)
            return f"The nearest that {able} misses the goal by {miss}: ({where})"
        return f"The nearest that {able}: {joint_moves(problem, free.moved)}"
