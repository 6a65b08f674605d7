"""Workers: the candidates of one round attempted in several processes; results come in their order.

The processes begin with a round and end with it. Where processes are forked, that takes 4 ms; where they are
spawned, they are sent problem, method and seeds, and take about a second to begin: the answer is the
same. What comes back is a result without its problem.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing import get_all_start_methods, get_context, get_start_method
from multiprocessing.connection import Connection, wait
from multiprocessing.context import BaseContext, DefaultContext
from multiprocessing.process import BaseProcess
from pickle import PicklingError
from signal import SIG_IGN, SIGINT, signal
from threading import active_count
from typing import cast

from trajopt.errors import ProblemError
from trajopt.planning.branch import GoalBranch
from trajopt.planning.budget import Budget, BudgetTracker, Stop, Stopped
from trajopt.planning.goal_search import Candidate, attempt
from trajopt.planning.result import Result
from trajopt.planning.seeds import MakeSeed, SeedKind
from trajopt.planning.status import Status
from trajopt.planning.workspace import Workspace
from trajopt.problem import Problem

POLL = 0.005
"""How often the budget is checked while waiting [s]."""
FAREWELL = 1.0
"""How long an ended process may take to go [s]."""

Answer = Result | Stop | Exception
"""What a worker sends for a candidate."""


@dataclass(eq=False)
class _Worker:
    """A process and the candidates that it has not answered yet, by number."""

    process: BaseProcess
    answers: Connection
    waiting: list[int]


def attempted_in_processes(candidates: Sequence[Candidate], tracker: BudgetTracker) -> Iterator[Result]:
    """Attempt candidates; yield their results in the order given, their work added to the tracker.

    Args:
        candidates: The candidates; the workers take turns.
        tracker: Of the whole of planning; its budget says how many workers there may be.

    Raises:
        Stopped: If the budget ends; whoever ends the iteration ends the processes.
    """
    running: list[_Worker] = []
    ready: dict[int, Answer] = {}
    try:
        workers = min(tracker.budget.workers, len(candidates))
        for share in range(workers):
            running.append(_start(candidates, share, workers, tracker))
        for number, candidate in enumerate(candidates):
            while number not in ready:
                tracker.check()
                _receive(running, ready, candidates)
            answer = ready.pop(number)
            if isinstance(answer, Stop):
                raise Stopped(answer)
            if isinstance(answer, Exception):
                raise answer
            tracker.add(answer.counts, answer.cpu_seconds)
            tracker.check()
            yield replace(answer, problem=candidate.workspace.problem)
    finally:
        for worker in running:
            worker.process.terminate()
            worker.process.join(FAREWELL)
            if worker.process.is_alive():
                worker.process.kill()
            worker.answers.close()


def _start(candidates: Sequence[Candidate], share: int, shares: int, tracker: BudgetTracker) -> _Worker:
    numbers = list(range(share, len(candidates), shares))
    context = start_context(tracker.budget.processes)
    answers, send = context.Pipe(duplex=False)
    mine = [candidates[number] for number in numbers]
    pieces = [
        _Piece(item.workspace.problem, item.branches, item.kind, item.make_seed, item.brief) for item in mine
    ]
    work = (pieces, replace(tracker.budget, processes=None), tracker.so_far, send)
    process = context.Process(target=_work, args=work, daemon=True)
    try:
        process.start()
    except (PicklingError, AttributeError, TypeError) as error:
        raise ProblemError(
            "workers that are not forked are sent problem, method and clock, which must be picklable "
            f"(no lambda, no function within another): {error}"
        ) from error
    send.close()
    return _Worker(process, answers, numbers)


def _receive(running: Sequence[_Worker], ready: dict[int, Answer], candidates: Sequence[Candidate]) -> None:
    """Wait a little for answers and take those that have come."""
    busy = {worker.answers: worker for worker in running if worker.waiting}
    for answers in wait(list(busy), POLL):
        worker = busy[cast(Connection, answers)]
        try:
            ready[worker.waiting.pop(0)] = worker.answers.recv()
        except EOFError:
            worker.process.join(FAREWELL)
            message = f"process {worker.process.pid} ended with {worker.process.exitcode}"
            for number in (*worker.waiting,):
                ready[number] = _died(candidates[number], message)
            worker.waiting.clear()


def _died(candidate: Candidate, message: str) -> Result:
    return replace(candidate.workspace.result(Status.WORKER_DIED, message), counts={}, cpu_seconds={})


@dataclass(frozen=True, eq=False)
class _Piece:
    """What a worker is sent of a candidate: data that any process can read."""

    problem: Problem
    branches: tuple[GoalBranch, ...]
    kind: SeedKind
    make_seed: MakeSeed
    brief: bool


def start_context(chosen: BaseContext | None) -> DefaultContext:
    """Return what starts workers: the one chosen, or the default where that can be trusted.

    A fork copies one thread only, with the locks that others hold: where there are several, processes are
    spawned.
    """
    if chosen is not None:
        return cast(DefaultContext, chosen)
    usual = get_start_method(allow_none=True) or get_all_start_methods()[0]
    return cast(DefaultContext, get_context("spawn" if usual == "fork" and active_count() > 1 else usual))


def _work(
    pieces: Sequence[_Piece], budget: Budget, so_far: tuple[int, float, float], send: Connection
) -> None:
    """Attempt candidates one after the other; this is the other process."""
    signal(SIGINT, SIG_IGN)  # The waiting process is interrupted instead, and ends this one.
    for piece in pieces:
        tracker = BudgetTracker.elsewhere(budget, so_far)
        answer: Answer
        try:
            work = Workspace(piece.problem, tracker)
            result = attempt(Candidate(work, piece.branches, piece.kind, piece.make_seed, piece.brief))
            answer = replace(result, problem=cast(Problem, None))
        except Stopped as stopped:
            answer = stopped.stop
        except Exception as error:
            answer = error
        with suppress(BrokenPipeError):
            send.send(answer)
        if not isinstance(answer, Result):
            return
        _, *used = tracker.so_far
        so_far = (so_far[0], used[0], used[1])
