"""Processes of this machine: the engine that needs nothing else."""

import os
import time
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.connection import wait

from trajopt.campaign.columns import Row, encoded
from trajopt.campaign.engine import Block, Lost, Planned, Pool, check_workers
from trajopt.campaign.kept import CampaignFolder
from trajopt.campaign.setup import Setup
from trajopt.campaign.supervisor import Supervisor
from trajopt.errors.arguments import checked


@checked
@dataclass(frozen=True)
class Local:
    """Processes of this machine.

    Attributes:
        workers: How many; as many as this process may use cores when 0.
    """

    workers: int = 0

    def __post_init__(self) -> None:
        """Refuse a negative number.

        Raises:
            ProblemError: If it is negative.
        """
        check_workers(self.workers)

    @contextmanager
    def pool(self, folder: CampaignFolder) -> Generator[Pool]:
        """Return the workers of a campaign, which end with the context."""
        workers = LocalPool(setup_of(folder), self.workers or cores())
        try:
            yield workers
        finally:
            workers.close()


class LocalPool:
    """Workers on this machine."""

    def __init__(self, setup: Setup, workers: int) -> None:
        """Note how many there may be; each is started with its first block."""
        self._setup, self.workers = setup, workers
        self._free: list[Supervisor] = []
        self._busy: dict[Supervisor, tuple[Block, float]] = {}

    @property
    def idle(self) -> int:
        """How many blocks can be submitted now."""
        return self.workers - len(self._busy)

    @property
    def pids(self) -> tuple[int, ...]:
        """Ids of the workers' processes."""
        return tuple(each.pid for each in (*self._busy, *self._free))

    def submit(self, block: Block) -> None:
        """Hand a block to a worker that has none."""
        worker = self._free.pop() if self._free else Supervisor(self._setup)
        self._busy[worker] = block, worker.waited
        worker.give(block.tasks)

    def wait(self, seconds: float) -> Sequence[Planned | Lost]:
        """Return what ended, waiting for it for so long at most [s].

        Raises:
            CampaignError: If workers cannot be started.
        """
        soonest = min((each.until for each in self._busy), default=0.0) - time.monotonic()
        pipes = {each.pipe: each for each in self._busy}
        ready = wait(list(pipes), timeout=max(0.0, min(seconds, soonest)))
        overdue = [each for each in self._busy if each.until < time.monotonic()]
        ended: list[Planned | Lost] = []
        for worker in dict.fromkeys((*(pipes[pipe] for pipe in ready), *overdue)):  # pyright: ignore
            rows = worker.advance()
            if rows is not None:
                self._free.append(worker)
                block, before = self._busy.pop(worker)
                ended.append(planned(block, rows, worker.waited - before))
        return ended

    def close(self) -> None:
        """End all workers."""
        for worker in (*self._busy, *self._free):
            worker.close()


def planned(block: Block, rows: Sequence[Row], waited: float) -> Planned:
    """Return what is told of a block whose problems all have a row.

    Args:
        block: The block.
        rows: The rows.
        waited: Wall-clock time that its worker waited for it [s].
    """
    busy = sum(row["cpu_seconds"]["total"] for row in rows if row.get("cpu_seconds"))
    seconds = sum(row["wall_seconds"] for row in rows)
    return Planned(block, encoded(rows), seconds, busy, waited, sum(bool(row["verified"]) for row in rows))


def setup_of(folder: CampaignFolder) -> Setup:
    """Return what the workers of a campaign are told first."""
    return Setup(folder.documents, folder.options, folder.versions, folder.most_seconds)


def cores() -> int:
    """Return how many cores this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # only Linux says so
        return os.cpu_count() or 1
