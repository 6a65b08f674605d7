"""CPU time of the stages of planning, and exact counts, of one problem planned several times."""

from dataclasses import dataclass

import numpy as np

import trajopt as to

STAGES = ("optimise", "retime", "verify")
COUNTS = ("distance_calls", "bounds", "qp_iterations", "judge_distance_calls")


@dataclass(frozen=True)
class Measurement:
    """One problem, planned several times in the same scene.

    Attributes:
        status: How planning ended.
        milliseconds: CPU time of each stage and of the whole, least of all runs [ms].
        counts: Exact numbers of the work.
    """

    status: str
    milliseconds: dict[str, float]
    counts: dict[str, int]


def measure(problem: to.Problem, runs: int = 5) -> Measurement:
    """Plan a problem several times after one run that is not counted.

    The least time of several is what the work takes; the rest of a longer one is other work on the
    same machine.
    """
    first = to.plan(problem)
    results = [to.plan(problem) for _ in range(runs)]
    milliseconds = {
        stage: 1e3 * min(result.cpu_seconds.get(stage, 0.0) for result in results) for stage in STAGES
    }
    milliseconds["plan"] = 1e3 * min(sum(result.cpu_seconds.values()) for result in results)
    counts = {name: int(first.counts.get(name, 0)) for name in COUNTS}
    return Measurement(first.status.name, milliseconds, counts)


def exponent(sizes: list[int], costs: list[float]) -> float:
    """Fit cost = c size^e by least squares on logarithms and return e."""
    slope, _ = np.polyfit(np.log(sizes), np.log(np.maximum(costs, 1e-6)), 1)
    return float(slope)
