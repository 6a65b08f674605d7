"""compare(problems, methods): the same problems, first guesses, budget and judge for every method."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from trajopt.lab.suite.instance import Instance, instances_of
from trajopt.lab.suite.outcome import Outcome
from trajopt.lab.suite.running import run
from trajopt.optimise.methods import Method, method_named
from trajopt.planning.budget import Budget
from trajopt.planning.result import Result
from trajopt.problem.problem import Problem
from trajopt.values.arrays import one_of, sequence
from trajopt.values.errors import MissingExtra
from trajopt.values.errors.arguments import checked


@checked
@dataclass(frozen=True)
class Allowance:
    """Budget of every method on every problem.

    Attributes:
        attempts: Largest number of seeds.
        cpu_seconds: Largest CPU time [s].
    """

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
) -> tuple[Outcome, ...]:
    """Plan every problem with every method, and judge all motions with the same judge.

    Args:
        problems: By name; or a sequence of problems or names of installed ones.
        methods: Methods, or names of installed ones.
        attempts: Largest number of seeds; all methods get the same ones in the same order.
        cpu_seconds: CPU time after which no further seed is tried [s].

    Raises:
        ProblemNotFound: If there is no installed problem of a name.
        SolverNotFound: If there is no method of a name.
        MissingExtra: If a package of a method is not installed.
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
) -> Iterator[Outcome]:
    """Yield every outcome, problem by problem.

    Args:
        instances: The problems.
        methods: The methods.
        allowance: The budget of each on each.
        skipped: Receives methods with missing packages, which are then skipped; None to raise.
        seen: Called with each result before its outcome, which has the numbers only, is yielded.

    Raises:
        MissingExtra: If a package of a method is not installed, and `skipped` is None.
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
    """Run a method once without recording, so that its imports are not measured."""
    try:
        run(instance, method, budget=Allowance(attempts=1).budget)
    except MissingExtra as error:
        if skipped is None:
            raise
        skipped(method, error)
        return False
    return True
