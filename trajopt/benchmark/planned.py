"""Planning with a bounded number of first guesses and of CPU seconds: the same budget for every method."""

import time
from dataclasses import dataclass

from trajopt.methods import Method
from trajopt.planning import Progress
from trajopt.planning.budget import Budget
from trajopt.planning.plan import plan
from trajopt.planning.result import Result
from trajopt.problem import Problem


@dataclass(frozen=True)
class Allowance:
    """What every method may use on every problem.

    Attributes:
        attempts: First guesses at most.
        cpu_seconds: Process time at most [s].
    """

    attempts: int = 8
    cpu_seconds: float = 30.0


def planned(problem: Problem, method: Method, allowance: Allowance, progress: Progress) -> Result:
    """Plan within an allowance; always with the same random numbers, so with the same first guesses."""
    budget = Budget(attempts=allowance.attempts, seconds=allowance.cpu_seconds, clock=time.process_time)
    return plan(problem, method=method, budget=budget, progress=progress)
