"""How each problem of a campaign is planned."""

import time
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from trajopt.optimise.methods import method_named
from trajopt.planning.budget import Budget
from trajopt.planning.plan import plan
from trajopt.planning.result import Result
from trajopt.problem.problem import Problem
from trajopt.values.errors.arguments import checked


@checked
@dataclass(frozen=True)
class Options:
    """Method, options and budget, as plain data.

    Attributes:
        method: Name of the method; the one that planning chooses when None.
        improve: Whether a motion shorter than along its path is looked for.
        every_goal: Whether all goals of a set are planned to.
        seconds: Process time that one problem may take [s]: its answer then depends on the machine.
        work: Configurations that one problem may evaluate: an exact number.
        attempts: Seeds that one problem may try.
    """

    method: str | None = None
    improve: bool = False
    every_goal: bool = False
    seconds: float | None = None
    work: int | None = None
    attempts: int | None = None

    def __post_init__(self) -> None:
        """Refuse what planning would refuse.

        Raises:
            SolverNotFound: If there is no method of that name.
            ProblemError: If a bound is not positive.
        """
        if self.method is not None:
            method_named(self.method)
        _ = self.budget

    @property
    def budget(self) -> Budget:
        """The bounds as a budget; time is that of the process, for others share its cores."""
        return Budget(self.seconds, self.work, self.attempts, clock=time.process_time)

    def plan(self, problem: Problem, seed: int) -> Result:
        """Plan a problem so; seed 0 gives what `plan` gives without one."""
        return plan(
            problem,
            method=self.method,
            improve=self.improve,
            every_goal=self.every_goal,
            budget=self.budget,
            rng=np.random.default_rng(seed) if seed else None,
        )

    def as_dict(self) -> dict[str, Any]:
        """Return what differs from the default, as plain data that JSON can hold."""
        changed = (item for item in fields(self) if getattr(self, item.name) != item.default)
        return {item.name: getattr(self, item.name) for item in changed}
