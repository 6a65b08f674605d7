"""The deadline: a motion is at its goal by then."""

from collections.abc import Iterator
from dataclasses import dataclass

from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.checks.criterion import Criterion
from trajopt.verify.kernel.motion import Motion


@dataclass(frozen=True, eq=False)
class DeadlineCriterion(Criterion):
    """The deadline of a motion, if it has one.

    Attributes:
        motion: The motion.
        finish_by: When it must be at the goal, its own start being at 0 [s]; None for any time.
        follows: How long it follows a goal that moves when it ends [s]: it is there before.
    """

    motion: Motion
    finish_by: float | None
    follows: float = 0.0

    def measure(self) -> Iterator[Check]:
        """State when the motion is at its goal."""
        if self.finish_by is None:
            return
        there = self.motion.duration - self.follows
        slack = self.finish_by - there
        late = f"{-slack:.3f} s late" if slack < 0.0 else f"{slack:.3f} s early"
        yield Check(
            kind=CheckKind.DEADLINE,
            name="finish by",
            subject="",
            value=there,
            bound=self.finish_by,
            unit="s",
            time=there,
            slack=slack,
            evidence=Evidence.PROVEN,
            holds=slack >= 0.0,
            detail=f"is at the goal at {there:.3f} s, {late}",
        )
