"""Run the problems of the suite, and compare methods on them."""

import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np

from trajopt.geometry import evaluator
from trajopt.lab.suite.instance import Instance, instances_of
from trajopt.lab.suite.outcome import IterationRecord, RunOutcome
from trajopt.optimise.methods import Knots, Method, method_named
from trajopt.optimise.solvers import Iteration
from trajopt.planning.budget import Budget
from trajopt.planning.experience import Experience
from trajopt.planning.judgement import judge
from trajopt.planning.plan import NO_BOUNDS, plan
from trajopt.planning.result import Result
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Floats, one_of, sequence
from trajopt.values.errors import MissingExtra
from trajopt.values.errors.arguments import checked
from trajopt.verify import Check

TIP_SAMPLES = 60


@checked
def run(
    instance: Instance,
    method: Method | None = None,
    *,
    budget: Budget = NO_BOUNDS,
    follow: bool = False,
    seen: Callable[[Result], None] | None = None,
    experience: Experience | None = None,
) -> RunOutcome:
    """Make and plan one problem, and judge the motion with a fresh judge.

    Args:
        follow: Whether to record every step of the solver, and the path of the last joint.
        seen: Called with the result, of which an outcome has the numbers only.
    """
    chosen = Knots() if method is None else method
    history: list[IterationRecord] = []
    attempt, fresh = 0, False

    def note(stage: str, step: Iteration | None) -> None:
        nonlocal attempt, fresh
        if step is None:
            fresh = fresh or stage == "optimise"
            return
        attempt, fresh = attempt + fresh, False
        history.append(IterationRecord(time.process_time() - made, attempt, step.cost, step.violation))

    begin = time.process_time()
    problem = instance.make()
    made = time.process_time()
    result = plan(
        problem, method=chosen, experience=experience, budget=budget, progress=note if follow else None
    )
    planned = time.process_time()
    if seen is not None:
        seen(result)
    trajectory, certificate, path = result.trajectory, result.certificate, result.path
    clearance = None if certificate is None else certificate.clearance
    return RunOutcome(
        problem=instance.name,
        draw=instance.draw,
        solver=chosen.name,
        expected=instance.expected,
        status=result.status,
        certainty=result.certainty,
        message=result.message,
        attempts=result.counts.get("attempts", 0),
        attempts_by_kind=dict(Counter(item.kind.name for item in result.attempts)),
        won_by=None if result.won is None else result.won.kind,
        setup_seconds=made - begin,
        cpu_seconds=planned - made,
        stages=dict(result.cpu_seconds),
        counts=dict(result.counts),
        iterations=len(history),
        cost=None if result.solve is None else result.solve.at.cost,
        duration=None if trajectory is None else trajectory.duration,
        path_length=None if path is None else path.length,
        clearance=clearance if clearance is not None and isfinite(clearance) else None,
        violations=_violations(result),
        constraints=_judged(result),
        stopped_by_clock=result.stopped_by_clock,
        history=tuple(history),
        tip=_tip(result) if follow else (),
    )


def _judged(result: Result) -> tuple[Check, ...]:
    if result.trajectory is None or not result.verified:
        return ()
    checks = judge(result.problem, result.trajectory).checks
    return tuple(check for check in checks if check.required)


def _violations(result: Result) -> dict[str, float]:
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
    trajectory = result.trajectory
    if trajectory is None:
        return ()
    reduced = result.problem.reduced
    positions = trajectory(np.linspace(0.0, trajectory.duration, TIP_SAMPLES))
    joint = reduced.model.getJointId(reduced.joint_names[-1])
    return _points(evaluator(reduced).kinematics(positions).translation[:, joint])


def _points(positions: Floats) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(round(float(number), 4) for number in row) for row in positions)


@checked
@dataclass(frozen=True)
class Allowance:
    """Budget of every method on every problem."""

    attempts: int = 8
    cpu_seconds: float = 30.0

    @property
    def budget(self) -> Budget:
        """The same as a budget of planning."""
        return Budget(attempts=self.attempts, seconds=self.cpu_seconds, clock=time.process_time)


@checked
def compare(
    problems: Mapping[str, Problem] | Sequence[Problem | str],
    methods: Sequence[Method | str],
    *,
    attempts: int = 8,
    cpu_seconds: float = 30.0,
) -> tuple[RunOutcome, ...]:
    """Plan every problem with every method, and judge all motions with the same judge.

    Args:
        problems: By name; or a sequence of problems or names of installed ones.
        attempts: Most seeds; all methods get the same ones in the same order.
        cpu_seconds: CPU time after which no further seed is tried [s].

    Raises:
        ProblemNotFound: Without an installed problem of a name.
        SolverNotFound: Without a method of a name.
        MissingExtra: Without a package of a method.
    """
    chosen = [
        method_named(item) if isinstance(item, str) else one_of("method", item, Method)
        for item in sequence("methods", methods)
    ]
    return tuple(compared(instances_of(problems), chosen, Allowance(attempts, cpu_seconds)))


@checked
def compared(
    instances: Sequence[Instance],
    methods: Sequence[Method],
    allowance: Allowance,
    *,
    skipped: Callable[[Method, MissingExtra], None] | None = None,
    seen: Callable[[Result], None] | None = None,
) -> Iterator[RunOutcome]:
    """Yield every outcome, problem by problem.

    Args:
        skipped: Receives methods with missing packages, which are then skipped; None to raise.
    """
    ready: list[Method] | None = None
    for instance in instances:
        if ready is None:
            ready = [method for method in methods if _works(instance, method, skipped)]
        for method in ready:
            yield run(instance, method, budget=allowance.budget, follow=True, seen=seen)


def _works(
    instance: Instance, method: Method, skipped: Callable[[Method, MissingExtra], None] | None
) -> bool:
    try:
        run(instance, method, budget=Allowance(attempts=1).budget)
    except MissingExtra as error:
        if skipped is None:
            raise
        skipped(method, error)
        return False
    return True
