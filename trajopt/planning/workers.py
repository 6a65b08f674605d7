"""Workers: candidates of one round tried in several processes, and told in their order.

The processes are forked when a round begins and end with it: a problem holds native objects that no
pickle can carry, and a fork of this process takes 4 ms. What comes back is a result without its problem.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from signal import SIG_IGN, SIGINT, signal
from typing import cast

from trajopt.budget import Stop
from trajopt.planning.meter import Meter, Stopped
from trajopt.planning.portfolio import Candidate, Done
from trajopt.problem import Problem
from trajopt.status import Status

POLL = 0.005
"""How often the budget is looked at while waiting [s]."""
FAREWELL = 1.0
"""How long an ended process may take to go [s]."""

Answer = Done | Stop | Exception
"""What a worker sends for a candidate."""


@dataclass(eq=False)
class _Worker:
    """A process and the candidates that it is yet to answer for, by number."""

    process: BaseProcess
    answers: Connection
    waiting: list[int]


def tried_in_processes(
    candidates: Sequence[Candidate], workers: int, meter: Meter
) -> Iterator[tuple[Candidate, Done]]:
    """Try candidates; yield each with what became of it, in the order given, its work added to the meter.

    Args:
        candidates: The first guesses; every worker takes each so many-th.
        workers: Processes at most.
        meter: Of the whole of planning.

    Raises:
        Stopped: If the budget ends; whoever ends the iteration ends the processes.
    """
    running = [_start(candidates, share, min(workers, len(candidates)), meter) for share in range(workers)]
    running = [worker for worker in running if worker is not None]
    ready: dict[int, Answer] = {}
    try:
        for number, candidate in enumerate(candidates):
            while number not in ready:
                meter.check()
                _receive(running, ready, candidates)
            answer = ready.pop(number)
            if isinstance(answer, Stop):
                raise Stopped(answer)
            if isinstance(answer, Exception):
                raise answer
            meter.add(answer.result.counts, answer.result.cpu_seconds)
            meter.check()
            yield candidate, _at_home(candidate, answer)
    finally:
        for worker in running:
            worker.process.terminate()
            worker.process.join(FAREWELL)
            if worker.process.is_alive():
                worker.process.kill()
            worker.answers.close()


def _start(candidates: Sequence[Candidate], share: int, shares: int, meter: Meter) -> _Worker | None:
    numbers = list(range(share, len(candidates), shares)) if share < shares else []
    if not numbers:
        return None
    context = get_context("fork")
    answers, send = context.Pipe(duplex=False)
    mine = [candidates[number] for number in numbers]
    process = context.Process(target=_work, args=(mine, meter, meter.used, send), daemon=True)
    process.start()
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


def _died(candidate: Candidate, message: str) -> Done:
    result = candidate.owner.attempts.result(Status.WORKER_DIED, message)
    return Done(replace(result, counts={}, cpu_seconds={}), ())


def _work(candidates: Sequence[Candidate], meter: Meter, used: float, send: Connection) -> None:
    """Try candidates one after the other; this is the other process."""
    signal(SIGINT, SIG_IGN)  # The one who waits is interrupted, and ends this.
    for candidate in candidates:
        attempts = candidate.owner.attempts
        attempts.meter = meter.elsewhere(used)
        answer: Answer
        try:
            done = candidate.owner.run(candidate)
            answer = replace(done, result=replace(done.result, problem=cast(Problem, None)))
        except Stopped as stopped:
            answer = stopped.stop
        except Exception as error:
            answer = error
        with suppress(BrokenPipeError):
            send.send(answer)
        if not isinstance(answer, Done):
            return
        used = attempts.meter.used


def _at_home(candidate: Candidate, done: Done) -> Done:
    return replace(done, result=replace(done.result, problem=candidate.owner.attempts.problem))
