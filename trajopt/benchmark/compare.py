"""compare(problems, methods): the same problems, first guesses, budget and judge for every method."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from math import isfinite

import numpy as np

from trajopt.arrays import one_of, sequence
from trajopt.benchmark.planned import Allowance, planned
from trajopt.benchmark.question import Question, given_questions
from trajopt.benchmark.run import Moment, Run, points
from trajopt.errors import MissingExtra
from trajopt.methods import Method, method_named
from trajopt.planning.result import Result
from trajopt.problem import Problem
from trajopt.query import Query
from trajopt.solvers import Iteration

TIP_SAMPLES = 60
"""Places along a motion at which the tip is noted."""


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
    return tuple(runs(given_questions(problems), chosen, Allowance(attempts, cpu_seconds)))


def runs(
    questions: Sequence[Question],
    methods: Sequence[Method],
    allowance: Allowance,
    *,
    skipped: Callable[[Method, MissingExtra], None] | None = None,
) -> Iterator[Run]:
    """Yield every run, problem by problem.

    Args:
        questions: The problems.
        methods: The methods.
        allowance: What each may use on each.
        skipped: Told of methods whose packages are missing, which are then left out; None to raise.

    Raises:
        MissingExtra: If what a method runs on is not installed, and nobody is to be told.
    """
    ready: list[Method] | None = None
    for question in questions:
        problem = question.make()
        if ready is None:
            ready = [method for method in methods if _works(problem, method, skipped)]
        for method in ready:
            yield run(question, problem, method, allowance)


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


def run(question: Question, problem: Problem, method: Method, allowance: Allowance) -> Run:
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
        problem=question.name,
        solver=method.name,
        expected=question.expected,
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
