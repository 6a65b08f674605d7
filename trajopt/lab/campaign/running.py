"""run_campaign(campaign, folder): plan every problem once, across interruptions."""

import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from trajopt.lab.campaign.campaign import Campaign, CampaignTask
from trajopt.lab.campaign.columns import encoded
from trajopt.lab.campaign.engine import Block, Engine, EnginePool, Lost, PlannedBlock
from trajopt.lab.campaign.kept import CampaignFolder
from trajopt.lab.campaign.row import Fate, lost_row
from trajopt.lab.campaign.supervisor import Local
from trajopt.values.errors import CampaignError, FileFormatError
from trajopt.values.errors.arguments import checked

BLOCK_SECONDS = 5.0
"""Work of a block [s]: the largest loss per worker of a lost machine. Writing a block takes 10 ms."""
FIRST, MOST = 2, 2000
"""Problems of a block: before their duration is known; and at most, since blocks are held in memory."""
LEAST_SECONDS = 0.25
"""Least work of a block [s]: below that its overhead dominates."""
SHARE = 4
"""Fewest remaining blocks for each worker, so that all end simultaneously. Source: Polychronopoulos and
Kuck, Guided self-scheduling, 1987.
"""
LOSSES = 5
"""Lost machines after which a single problem counts as their cause."""
FAILURES = 3
"""Shards in a row that cannot be written before the campaign ends."""
REPORT = 1.0
"""Longest interval between progress reports [s]."""


@dataclass(frozen=True)
class Progress:
    """Progress of a campaign.

    Attributes:
        busy: CPU time of planning in this run [s].
        waited: Wall-clock time that workers waited for work in this run [s].
        losses: Blocks whose worker was lost with its machine.
        unwritten: Blocks whose rows could not be written, and were planned again.
    """

    done: int
    total: int
    verified: int = 0
    planned: int = 0
    seconds: float = 0.0
    busy: float = 0.0
    waited: float = 0.0
    losses: int = 0
    unwritten: int = 0

    @property
    def rate(self) -> float:
        """Rows in a second of this run; 0 before the first."""
        return self.planned / self.seconds if self.seconds else 0.0

    @property
    def left(self) -> float | None:
        """Time until all is done at this rate [s]; None before the first row."""
        return (self.total - self.done) / self.rate if self.planned else None


@checked
def run_campaign(
    campaign: Campaign,
    folder: Path | str,
    engine: Engine | None = None,
    *,
    progress: Callable[[Progress], None] | None = None,
) -> CampaignFolder:
    """Plan every problem of a campaign, and store a row for each in a folder.

    Args:
        engine: Processes of this machine if None.
        progress: Called at least about every second.

    Raises:
        MissingExtra: If pyarrow, or a package of the engine, is not installed.
        CampaignError: If the folder has a campaign, rows cannot be written, or workers cannot be started.
        ModelError: If a problem contains code of the caller, which cannot be sent to a worker.
    """
    return resume_campaign(CampaignFolder.begin(campaign, folder).path, engine, progress=progress)


@checked
def resume_campaign(
    folder: Path | str,
    engine: Engine | None = None,
    *,
    progress: Callable[[Progress], None] | None = None,
) -> CampaignFolder:
    """Plan the problems without a row; arguments and errors as for `run_campaign`."""
    opened = CampaignFolder.open(folder)
    opened.check_versions()
    done = len(opened.done())
    if done < opened.total:
        with (engine or Local()).pool(opened) as pool:
            _Run(opened, pool, done, progress).go()
    return opened


class _Run:
    def __init__(
        self,
        folder: CampaignFolder,
        pool: EnginePool,
        done: int,
        progress: Callable[[Progress], None] | None,
    ) -> None:
        self._folder, self._pool, self._tell = folder, pool, progress
        self._missing: Iterator[CampaignTask] = folder.missing()
        self._left = folder.total - done
        self._again: deque[Block] = deque()
        self._running, self._failures, self._pace, self._exhausted = 0, 0, 0.0, False
        self._state, self._begun = Progress(done, folder.total), time.monotonic()

    def go(self) -> None:
        while True:
            while self._pool.idle and (block := self._next()) is not None:
                self._running += 1
                self._pool.submit(block)
            if self._exhausted and not self._running and not self._again:
                return
            for ended in self._pool.wait(REPORT):
                self._running -= 1
                match ended:
                    case PlannedBlock():
                        self._keep(ended)
                    case Lost():
                        self._lost(ended)
            self._note(seconds=time.monotonic() - self._begun)

    def _next(self) -> Block | None:
        if self._again:
            return self._again.popleft()
        size = FIRST
        if self._pace:
            fair = self._pace * self._left / (SHARE * self._pool.workers)
            seconds = min(BLOCK_SECONDS, max(LEAST_SECONDS, fair))
            size = max(1, min(MOST, int(seconds / self._pace)))
        tasks = [task for _, task in zip(range(size), self._missing, strict=False)]
        self._left, self._exhausted = self._left - len(tasks), not tasks
        return Block(tasks) if tasks else None

    def _keep(self, ended: PlannedBlock) -> None:
        count = len(ended.block.tasks)
        self._pace = ended.seconds / count
        try:
            self._folder.write(ended.shard)
        except FileFormatError as error:
            self._failures += 1
            if self._failures >= FAILURES:
                raise CampaignError(
                    f"rows cannot be written: {error}; the rows written before are kept: "
                    f"trajopt campaign resume {self._folder.path}"
                ) from error
            self._again.append(ended.block)
            self._note(unwritten=self._state.unwritten + 1)
            return
        self._failures, state = 0, self._state
        self._note(
            done=state.done + count,
            planned=state.planned + count,
            verified=state.verified + ended.verified,
            busy=state.busy + ended.busy,
            waited=state.waited + ended.waited,
        )

    def _lost(self, ended: Lost) -> None:
        block = ended.block
        if not ended.begun:
            self._again.appendleft(block)  # before those that were at work when a machine was lost
            return
        self._note(losses=self._state.losses + 1)
        if len(block.tasks) > 1:
            half = len(block.tasks) // 2
            self._again += [Block(block.tasks[:half]), Block(block.tasks[half:])]
        elif block.losses + 1 < LOSSES:
            self._again.append(Block(block.tasks, block.losses + 1))
        else:
            self._folder.write(encoded([lost_row(block.tasks[0], Fate.CRASHED, ended.why, 0.0)]))
            self._note(done=self._state.done + 1, planned=self._state.planned + 1)

    def _note(self, **changed: float) -> None:
        self._state = replace(self._state, **changed)  # pyright: ignore[reportArgumentType]
        if self._tell is not None:
            self._tell(self._state)
