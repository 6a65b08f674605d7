"""Processes that plan problems under a clock: a hang or crash costs one problem only."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess

STARTING = 900.0
"""Seconds in which a process has to be ready, robots loaded."""

Key = tuple[str, int]
Row = dict[str, object]
_CONTEXT = get_context("spawn")


def _serve(pipe: Connection, ask: Callable[[str, int], "Row"], prepare: Callable[[], object] | None) -> None:
    """Plan the problems from the pipe until it is closed."""
    if prepare is not None:
        prepare()
    pipe.send(None)  # ready: what is imported does not count
    while (key := pipe.recv()) is not None:
        pipe.send(ask(*key))


@dataclass(eq=False)
class _Worker:
    process: BaseProcess
    pipe: Connection
    key: Key | None = None
    until: float = 0.0

    def give(self, key: Key | None, seconds: float) -> None:
        """Send a problem, or None at the end."""
        self.key, self.until = key, time.monotonic() + seconds
        self.pipe.send(key)

    def end(self) -> None:
        self.process.kill()
        self.process.join()
        self.pipe.close()


def _started(ask: Callable[[str, int], Row], prepare: Callable[[], object] | None) -> _Worker:
    mine, theirs = _CONTEXT.Pipe()
    process = _CONTEXT.Process(target=_serve, args=(theirs, ask, prepare), daemon=False)
    process.start()
    theirs.close()
    return _Worker(process, mine, None, time.monotonic() + STARTING)


def run(
    keys: Sequence[Key],
    *,
    ask: Callable[[str, int], Row],
    workers: int,
    seconds: float,
    keep: Callable[[Row], None],
    prepare: Callable[[], object] | None = None,
) -> None:
    """Ask problems and keep their rows.

    Args:
        keys: Family and number of each.
        ask: Asks one; a function of a module, for it goes to other processes.
        workers: How many processes.
        seconds: Wall-clock time of one problem at most.
        keep: Takes each row.
        prepare: What each process does before its first problem, within a time of its own.
    """
    waiting = list(reversed(keys))
    busy = [_started(ask, prepare) for _ in range(min(workers, len(keys)))]
    try:
        while busy:
            soonest = max(0.0, min(worker.until for worker in busy) - time.monotonic())
            ready = set(wait([worker.pipe for worker in busy], timeout=min(soonest, 5.0)))
            for worker in list(busy):
                if worker.pipe in ready:
                    row = _received(worker)
                elif time.monotonic() > worker.until:
                    row = _lost(worker, "hang", f"ended after {seconds:g} s")
                else:
                    continue
                if row is not None:
                    keep(row)
                if worker.process.is_alive() and (row is None or row["outcome"] != "hang"):
                    _go_on(worker, busy, waiting, seconds)
                    continue
                worker.end()
                busy.remove(worker)
                if waiting:
                    busy.append(_started(ask, prepare))
    finally:
        for worker in busy:
            worker.end()


def _go_on(worker: _Worker, busy: list[_Worker], waiting: list[Key], seconds: float) -> None:
    if waiting:
        worker.give(waiting.pop(), seconds)
        return
    worker.pipe.send(None)
    worker.process.join()
    worker.pipe.close()
    busy.remove(worker)


def _received(worker: _Worker) -> Row | None:
    """Return a row, None for a worker that is ready, or a crash for one that died."""
    try:
        return worker.pipe.recv()
    except EOFError:
        worker.process.join()
        return _lost(worker, "crash", f"the process died, exit code {worker.process.exitcode}")


def _lost(worker: _Worker, outcome: str, detail: str) -> Row:
    if worker.key is None:
        raise RuntimeError(f"a process was not ready: {detail}")
    family, seed = worker.key
    return {
        "key": f"{family}-{seed}", "family": family, "seed": seed, "outcome": outcome, "detail": detail
    }  # fmt: skip
