"""Performance profile: the share of problems that a method solves within a factor of the best one's time.

Source: Dolan and More, Benchmarking optimization software with performance profiles, Math. Prog. 91 (2002).
"""

from collections.abc import Mapping, Sequence

import numpy as np

from trajopt.arrays import Floats
from trajopt.benchmark.run import Run


def performance_profile(runs: Sequence[Run]) -> Mapping[str, Floats]:
    """Return for each method the ratios of its CPU time to the best one's, ascending.

    The profile rises by one over the number of problems at each ratio; what a method does not solve is no
    ratio at all. Only problems that have a solution count, whether or not any method finds it.

    Returns:
        Method -> ratios, shape (number of problems,), inf where it found no verified motion.
    """
    asked = [run for run in runs if run.askable and run.expected.name == "SOLVED"]
    problems = list(dict.fromkeys(run.problem for run in asked))
    best: dict[str, float] = {}
    for run in asked:
        if run.verified:
            best[run.problem] = min(run.cpu_seconds, best.get(run.problem, np.inf))
    profile: dict[str, Floats] = {}
    for solver in dict.fromkeys(run.solver for run in asked):
        times = {run.problem: run.cpu_seconds for run in asked if run.solver == solver and run.verified}
        ratios = [times[name] / best[name] if name in times else np.inf for name in problems]
        profile[solver] = np.sort(np.array(ratios))
    return profile
