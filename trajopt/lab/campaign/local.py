"""Processes of this machine: the engine that needs nothing else."""

import os
import time
from collections import deque
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.connection import wait

from trajopt.lab.campaign.columns import encoded
from trajopt.lab.campaign.engine import AHEAD, Block, Lost, Planned, Pool, Setup, check_workers
from trajopt.lab.campaign.kept import CampaignFolder
from trajopt.lab.campaign.supervisor import Worked, WorkerSupervisor
from trajopt.values.errors.arguments import checked


@checked
@dataclass(frozen=True)
class Local:
    """Processes of this machine.

    Attributes:
        workers: Their number; 0 for the number of usable cores.
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
        """Store the number of workers; each is started with its first block."""
        self._setup, self.workers = setup, workers
        self._blocks: dict[WorkerSupervisor, deque[Block]] = {}

    @property
    def idle(self) -> int:
        """Number of blocks that can be submitted now."""
        return AHEAD * self.workers - sum(map(len, self._blocks.values()))

    def submit(self, block: Block) -> None:
        """Hand a block to the worker that has least."""
        least = min(self._blocks, key=lambda each: len(self._blocks[each]), default=None)
        if least is None or (self._blocks[least] and len(self._blocks) < self.workers):
            least = WorkerSupervisor(self._setup)
            self._blocks[least] = deque()
        self._blocks[least].append(block)
        least.give(block.tasks)

    def wait(self, seconds: float) -> Sequence[Planned | Lost]:
        """Return finished blocks; wait at most a number of seconds.

        Raises:
            CampaignError: If workers cannot be started.
        """
        pipes = {each.pipe: each for each, blocks in self._blocks.items() if blocks}
        soonest = min((each.until for each in pipes.values()), default=0.0) - time.monotonic()
        ready = wait(list(pipes), timeout=max(0.0, min(seconds, soonest)))
        overdue = [each for each in pipes.values() if each.until < time.monotonic()]
        ended: list[Planned | Lost] = []
        for worker in dict.fromkeys((*(pipes[pipe] for pipe in ready), *overdue)):  # pyright: ignore
            while (worked := worker.advance()) is not None:  # what is told at once may end both of its blocks
                ended.append(planned(self._blocks[worker].popleft(), worked))
        return ended

    def close(self) -> None:
        """End all workers."""
        for worker in self._blocks:
            worker.close()


def planned(block: Block, worked: Worked) -> Planned:
    """Return the report of a finished block.

    Args:
        block: The block.
        worked: Its results.
    """
    rows = worked.rows
    busy = sum(row["cpu_seconds"]["total"] for row in rows if row.get("cpu_seconds"))
    seconds = sum(row["wall_seconds"] for row in rows)
    verified = sum(bool(row["verified"]) for row in rows)
    return Planned(block, encoded(rows), seconds, busy, worked.waited, verified)


def setup_of(folder: CampaignFolder) -> Setup:
    """Return the initial message to the workers of a campaign."""
    return Setup(folder.documents, folder.options, folder.versions, folder.most_seconds)


def cores() -> int:
    """Return the number of usable cores."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # only Linux says so
        return os.cpu_count() or 1
