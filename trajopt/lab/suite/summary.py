"""Summary of each method over all problems, side by side."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.lab.suite.outcome import Outcome
from trajopt.planning.status import Status
from trajopt.values.arrays import Floats


@dataclass(frozen=True)
class Summary:
    """One method over all valid problems.

    Attributes:
        solver: Name of the method.
        total: Number of problems.
        good: Problems with the expected outcome: a verified motion, or the right refusal.
        groups: Both numbers (good, total) by group of problems.
        cpu_total: CPU time over all problems [s].
        cpu_median: Median over the problems with a verified motion [s]; None without any, like the following.
        iterations: Median number of steps.
        cost: Median ratio of its cost to the least of all methods on the same problem.
        duration: Median ratio of the motion's duration to the least.
        path_length: Median ratio of the path's length to the least.
        clearance: Smallest proven clearance [m].
    """

    solver: str
    total: int
    good: int
    groups: dict[str, tuple[int, int]]
    cpu_total: float
    cpu_median: float | None
    iterations: float | None
    cost: float | None
    duration: float | None
    path_length: float | None
    clearance: float | None


def summaries(runs: Sequence[Outcome]) -> tuple[Summary, ...]:
    """Return the summary of each method, in the order of appearance, without invalid problems."""
    asked = [run for run in runs if run.askable]
    return tuple(
        _summary(solver, [run for run in asked if run.solver == solver], asked)
        for solver in dict.fromkeys(run.solver for run in runs)
    )


def _summary(solver: str, mine: Sequence[Outcome], everybody: Sequence[Outcome]) -> Summary:
    solved = [run for run in mine if run.verified]
    groups = dict.fromkeys(run.set_name for run in mine)
    return Summary(
        solver=solver,
        total=len(mine),
        good=sum(run.good for run in mine),
        groups={
            name: (
                sum(run.good for run in mine if run.set_name == name),
                sum(run.set_name == name for run in mine),
            )
            for name in groups
        },
        cpu_total=sum(run.cpu_seconds for run in mine),
        cpu_median=_median([run.cpu_seconds for run in solved]),
        iterations=_median([float(run.iterations) for run in solved]),
        cost=_ratio(solved, everybody, lambda run: run.cost),
        duration=_ratio(solved, everybody, lambda run: run.duration),
        path_length=_ratio(solved, everybody, lambda run: run.path_length),
        clearance=min((run.clearance for run in solved if run.clearance is not None), default=None),
    )


def _ratio(
    solved: Sequence[Outcome], everybody: Sequence[Outcome], measure: Callable[[Outcome], float | None]
) -> float | None:
    """Return the median ratio to the best of all methods, over the problems that a method solved."""
    least: dict[str, float] = {}
    for run in everybody:
        value = measure(run)
        if run.verified and value is not None:
            least[run.problem] = min(value, least.get(run.problem, value))
    ratios = [
        value / least[run.problem]
        for run in solved
        if (value := measure(run)) is not None and least[run.problem] > 0.0
    ]
    return _median(ratios)


def _median(values: Sequence[float]) -> float | None:
    return float(np.median(values)) if values else None


def performance_profile(runs: Sequence[Outcome]) -> Mapping[str, Floats]:
    """Return for each method the ratios of its CPU time to the best one's, ascending.

    The profile rises by one over the number of problems at each ratio; an unsolved problem has no
    ratio. Only problems with a solution count, whether or not any method finds it.

    Source: Dolan and More, Benchmarking optimization software with performance profiles, 2002.

    Returns:
        Method -> ratios, shape (number of problems,), inf for unsolved problems.
    """
    asked = [run for run in runs if run.askable and run.expected is Status.SOLVED]
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
