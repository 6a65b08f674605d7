"""Planning with a bounded number of first guesses and of CPU seconds: the same budget for every method."""

import time
from dataclasses import dataclass, replace

import numpy as np

from trajopt.methods import Method
from trajopt.planning import Planning, Progress
from trajopt.problem import Problem
from trajopt.result import Result


@dataclass(frozen=True)
class Allowance:
    """What every method may use on every problem.

    Attributes:
        attempts: First guesses at most, at each goal.
        cpu_seconds: No other first guess is begun after so much process time [s].
    """

    attempts: int = 8
    cpu_seconds: float = 30.0


def planned(problem: Problem, method: Method, allowance: Allowance, progress: Progress) -> Result:
    """Plan within an allowance; always with the same random numbers, so with the same first guesses."""
    begin, rng = time.process_time(), np.random.default_rng(0)
    goals = problem.alternatives or {"": problem}
    runs = [Planning(each, method, rng, progress) for each in goals.values()]
    refusals = [run.prepare() for run in runs]
    ready = [run for run, refusal in zip(runs, refusals, strict=True) if refusal is None]
    ready.sort(key=lambda run: run.travel)
    result = next((refusal for refusal in refusals if refusal is not None), None)
    for run in (run for _ in range(allowance.attempts) for run in ready):
        result = run.attempt(1)
        if result.verified or time.process_time() - begin > allowance.cpu_seconds:
            break
    assert result is not None
    attempts = sum(run.counts.get("attempts", 0) for run in runs)
    return replace(result, counts={**result.counts, "attempts": attempts})
