"""compare(problems, methods): the same problems, first guesses, budget and judge for every method."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np

from trajopt.arrays import one_of, sequence
from trajopt.benchmark.definition import Definition, definitions_of
from trajopt.benchmark.run import Moment, Run, points
from trajopt.errors import MissingExtra
from trajopt.methods import Method, method_named
from trajopt.planning import Progress
from trajopt.planning.budget import Budget
from trajopt.planning.plan import plan
from trajopt.planning.result import Result
from trajopt.problem import Problem
from trajopt.query import Query
from trajopt.solvers import Iteration

TIP_SAMPLES = 60
"""Places along a motion at which the tip is noted."""


@dataclass(frozen=True)
class Allowance:
    """What every method may use on every problem.

    Attributes:
        attempts: First guesses at most.
        cpu_seconds: Process time at most [s].
    """

    attempts: int = 8
    cpu_seconds: float = 30.0


def compare(
    problems: Mapping[str, Problem] | Sequence[Problem | str],
    methods: Sequence[Method | str],
    *,
    attempts: int = 8,
    cpu_seconds: float = 30.0,
) -> tuple[Run, ...]:
    """Plan every problem with every method, and have every motion judged by the same judge.

    Args:
        problems: By name; or in a row, each a problem or the name of an installed one.
        methods: Methods, or names of installed ones.
        attempts: First guesses at most; all methods get the same ones in the same order.
        cpu_seconds: No other first guess is begun after so much process time [s].

    Raises:
        ProblemNotFound: If there is no installed problem of a name.
        SolverNotFound: If there is no method of a name.
        MissingExtra: If what a method runs on is not installed.
    """
    chosen = [
        method_named(item) if isinstance(item, str) else one_of("method", item, Method)
        for item in sequence("methods", methods)
    ]
    return tuple(runs(definitions_of(problems), chosen, Allowance(attempts, cpu_seconds)))


def runs(
    problems: Sequence[Definition],
    methods: Sequence[Method],
    allowance: Allowance,
    *,
    skipped: Callable[[Method, MissingExtra], None] | None = None,
) -> Iterator[Run]:
    """Yield every run, problem by problem.

    Args:
        problems: The problems.
        methods: The methods.
        allowance: What each may use on each.
        skipped: Told of methods whose packages are missing, which are then left out; None to raise.

    Raises:
        MissingExtra: If what a method runs on is not installed, and nobody is to be told.
    """
    ready: list[Method] | None = None
    for definition in problems:
        problem = definition.problem()
        if ready is None:
            ready = [method for method in methods if _works(problem, method, skipped)]
        for method in ready:
            yield run(definition, problem, method, allowance)


def planned(problem: Problem, method: Method, allowance: Allowance, progress: Progress) -> Result:
    """Plan within an allowance; always with the same random numbers, so with the same first guesses."""
    budget = Budget(attempts=allowance.attempts, seconds=allowance.cpu_seconds, clock=time.process_time)
    return plan(problem, method=method, budget=budget, progress=progress)


def _works(problem: Problem, method: Method, skipped: Callable[[Method, MissingExtra], None] | None) -> bool:
    """Try a method once, unrecorded: what it imports when first used is no part of any measurement."""
    try:
        planned(problem, method, Allowance(attempts=1), lambda stage, step: None)
    except MissingExtra as error:
        if skipped is None:
            raise
        skipped(method, error)
        return False
    return True


def run(definition: Definition, problem: Problem, method: Method, allowance: Allowance) -> Run:
    """Plan one problem with one method."""
    history: list[Moment] = []
    attempt, fresh, begin = 0, False, time.process_time()

    def note(stage: str, step: Iteration | None) -> None:
        nonlocal attempt, fresh
        if step is None:
            fresh = fresh or stage == "optimise"
            return
        attempt, fresh = attempt + fresh, False
        history.append(Moment(time.process_time() - begin, attempt, step.cost, step.violation))

    result = planned(problem, method, allowance, note)
    used = time.process_time() - begin
    trajectory, certificate, path = result.trajectory, result.certificate, result.path
    clearance = None if certificate is None else certificate.clearance
    return Run(
        problem=definition.name,
        solver=method.name,
        expected=definition.expected,
        status=result.status,
        message=result.message,
        attempts=result.counts.get("attempts", 0),
        cpu_seconds=used,
        iterations=len(history),
        cost=None if result.solve is None else result.solve.at.cost,
        duration=None if trajectory is None else trajectory.duration,
        path_length=None if path is None else path.length,
        clearance=clearance if clearance is not None and isfinite(clearance) else None,
        violations=_violations(result),
        history=tuple(history),
        tip=_tip(result),
    )


def _violations(result: Result) -> dict[str, float]:
    """Return what is broken: as the judge says, or where nothing was judged as the solver says."""
    if result.certificate is not None:
        return {
            check.name: -check.slack if check.slack is not None else float("nan")
            for check in result.certificate.failed
        }
    if result.solve is None:
        return {}
    broken = [block for block in result.solve.at.constraints if block.worst > block.tolerance]
    return {block.name: block.worst for block in sorted(broken, key=lambda block: block.worst)}


def _tip(result: Result) -> tuple[tuple[float, ...], ...]:
    """Return where the group's last joint goes."""
    trajectory = result.trajectory
    if trajectory is None:
        return ()
    reduced = result.problem.reduced
    positions = trajectory(np.linspace(0.0, trajectory.duration, TIP_SAMPLES))
    joint = reduced.model.getJointId(reduced.joint_names[-1])
    return points(Query(reduced).kinematics(positions).translation[:, joint])
