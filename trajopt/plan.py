"""plan(problem): the whole of planning in one call; of a goal set, to the goal that comes easiest."""

from dataclasses import replace

import numpy as np

from trajopt.methods import Knots, Method
from trajopt.planning import ATTEMPTS, Planning, Progress
from trajopt.problem import Problem
from trajopt.result import Result, Status
from trajopt.tries import Try

FIRST_ATTEMPTS = 4
"""First guesses that every goal of a set gets before any gets more: straight lines."""


def plan(
    problem: Problem,
    *,
    method: Method | None = None,
    rng: np.random.Generator | None = None,
    progress: Progress | None = None,
) -> Result:
    """Plan a motion and have it judged.

    Args:
        problem: What the motion must achieve.
        method: Transcription and solver with their options; sequential QP over knots when None.
        rng: Draws the starts of inverse kinematics; a fixed seed when None, so that the answer is
            the same every time.
        progress: Called at every stage and every step of the solver.

    Returns:
        A result; `result.require()` gives the plan or raises with the reason.

    Raises:
        ProblemError: If a requirement cannot be asked of this robot.
    """
    method, rng = method or Knots(), rng or np.random.default_rng(0)
    if problem.alternatives:
        runs = {name: Planning(each, method, rng, progress) for name, each in problem.alternatives.items()}
        return _to_any(problem, runs)
    run = Planning(problem, method, rng, progress)
    return run.prepare() or run.attempt(ATTEMPTS)


def _to_any(problem: Problem, runs: dict[str, Planning]) -> Result:
    """Plan to the nearest goal first; all get straight lines before any gets more than that."""
    results: dict[str, Result] = {}
    for name, run in runs.items():
        refusal = run.prepare()
        if refusal is not None:
            results[name] = refusal
    order = sorted((name for name in runs if name not in results), key=lambda name: runs[name].travel)
    for attempts in (FIRST_ATTEMPTS, ATTEMPTS - FIRST_ATTEMPTS):
        for name in order:
            results[name] = runs[name].attempt(attempts)
            if results[name].status is Status.SOLVED:
                counts, seconds = _work(runs)
                return replace(
                    results[name], goal_name=name, tries=_tries(runs), counts=counts, cpu_seconds=seconds
                )
    ranked = {name: results[name] for name in (*order, *(name for name in runs if name not in order))}
    first = next(iter(ranked.values()))
    message = "; ".join(f"{name}: {results[name].reason}" for name in runs)
    counts, seconds = _work(runs)
    return replace(
        first,
        problem=problem,
        message=message,
        alternatives=ranked,
        tries=_tries(runs),
        counts=counts,
        cpu_seconds=seconds,
    )


def _work(runs: dict[str, Planning]) -> tuple[dict[str, int], dict[str, float]]:
    """Sum up the counts and process times of all runs."""
    counts: dict[str, int] = {}
    seconds: dict[str, float] = {}
    for run in runs.values():
        for name, count in run.counts.items():
            counts[name] = counts.get(name, 0) + count
        for name, time in run.seconds.items():
            seconds[name] = seconds.get(name, 0.0) + time
    return counts, seconds


def _tries(runs: dict[str, Planning]) -> tuple[Try, ...]:
    """Return the tries of all runs, goal by goal."""
    every = [replace(item, goal_name=name) for name, run in runs.items() for item in run.tries]
    return tuple(replace(item, number=number) for number, item in enumerate(every, 1))
