"""plan_many(problems): many plans side by side, each as if planned alone."""

import os
import sys
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sized
from contextlib import contextmanager
from threading import Event
from typing import Protocol

from trajopt.planning.plan import plan
from trajopt.planning.result import Result
from trajopt.problem.problem import Problem
from trajopt.values.arrays import function, one_of, sequence
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked

AHEAD = 2
"""Problems taken ahead for each worker, so that none waits for another's long one."""


class PlansProblem(Protocol):
    """Plans one problem."""

    def __call__(self, problem: Problem, /, *, cancel: Event | None = None) -> Result: ...


@checked
def plan_many(
    problems: Iterable[Problem],
    *,
    workers: int | None = None,
    planner: PlansProblem = plan,
    bar: bool = True,
) -> Iterator[Result]:
    """Plan many problems side by side in threads; yield the results in the order of the problems.

    Results do not depend on the number of workers. Ending the iteration ends the planning.

    Args:
        workers: Threads; the number of cores when None.
        planner: Plans one; `functools.partial(to.plan, seconds=1.0)` plans with options.
        bar: Whether a progress bar is shown while standard error is a terminal.

    Raises:
        ProblemError: If an argument is of the wrong kind, or, at its turn, an item is not a problem.
            Exceptions of the planner are raised at the turn of their problem.
    """
    count = os.cpu_count() or 1 if workers is None else workers
    if type(count) is not int or count < 1:
        raise ProblemError(f"workers must be a positive whole number, is {shown(count)}")
    if not isinstance(problems, Iterator):
        problems = sequence("problems", problems)
    function("planner", planner)
    return _planned(problems, count, planner, bar=one_of("bar", bar, bool))


def _planned(
    problems: Iterable[Problem], workers: int, planner: PlansProblem, *, bar: bool
) -> Iterator[Result]:
    from concurrent.futures import Future, ThreadPoolExecutor

    over = Event()
    running: deque[Future[Result]] = deque()

    def alone(problem: Problem) -> Result:
        return planner(one_of("each of problems", problem, Problem), cancel=over)

    with _bar(len(problems) if isinstance(problems, Sized) else None, shown=bar) as advance:
        pool = ThreadPoolExecutor(workers, "trajopt")
        try:
            for problem in problems:
                running.append(pool.submit(alone, problem))
                while running and (running[0].done() or len(running) > AHEAD * workers):
                    yield running.popleft().result()
                    advance()
            for planned in running:
                yield planned.result()
                advance()
        finally:
            over.set()
            pool.shutdown(cancel_futures=True)


@contextmanager
def _bar(total: int | None, *, shown: bool) -> Generator[Callable[[], None]]:
    if not (shown and sys.stderr.isatty()):
        yield lambda: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

    columns = BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    with Progress("planning", *columns, console=Console(stderr=True)) as progress:
        task = progress.add_task("planning", total=total)
        yield lambda: progress.advance(task)
