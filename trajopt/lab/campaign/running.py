"""run_campaign(campaign, folder): every problem planned once, however often it has to be begun again."""

import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from trajopt.lab.campaign.campaign import Campaign, Task
from trajopt.lab.campaign.columns import encoded
from trajopt.lab.campaign.engine import Block, Engine, Lost, Planned, Pool
from trajopt.lab.campaign.kept import CampaignFolder
from trajopt.lab.campaign.local import Local
from trajopt.lab.campaign.row import Fate, lost_row
from trajopt.values.errors import CampaignError, FileFormatError
from trajopt.values.errors.arguments import checked

BLOCK_SECONDS = 5.0
"""Work of a block [s]: what a lost machine costs of each of its workers at most. Writing one takes a
hundredth of a second."""
FIRST, MOST = 2, 2000
"""Problems of a block: as long as nobody knows how long they take; and whatever they take, for a block is
held in memory."""
LEAST_SECONDS = 0.25
"""Work of a block at the end [s]: below that handing it over, and a file for it, count for more."""
SHARE = 4
"""Blocks that each worker is to get of what is left, at least, so that all end at the same time. Source:
Polychronopoulos and Kuck, Guided self-scheduling, 1987."""
LOSSES = 5
"""Times that the machine under a problem alone may be lost before the problem is held responsible: machines
that come and go by themselves hardly ever meet the same one so often."""
FAILURES = 3
"""Shards in a row that cannot be written before the campaign ends: a disk that is full stays so."""
LOOK = 1.0
"""How often progress is told, at least [s]."""


@dataclass(frozen=True)
class Progress:
    """How far a campaign is.

    Attributes:
        done: Rows there are, those of earlier runs included.
        total: Rows there are to be.
        verified: Rows of this run with a verified motion.
        planned: Rows of this run.
        seconds: Wall-clock time of this run [s].
        busy: Process time of planning in this run [s].
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
    """Plan every problem of a campaign, and keep a row of each in a folder.

    Args:
        campaign: The campaign.
        folder: Where it is kept; it holds no other campaign.
        engine: What plans: processes of this machine when None.
        progress: Called now and then, at least every second or so.

    Returns:
        The folder with all rows. What was interrupted is gone on with by `resume_campaign`.

    Raises:
        MissingExtra: If pyarrow, or what the engine stands on, is not installed.
        CampaignError: If the folder holds a campaign, rows cannot be written, or workers cannot be started.
        ModelError: If a problem holds code of the caller's, which no worker can be sent.
    """
    return resume_campaign(CampaignFolder.begin(campaign, folder).path, engine, progress=progress)


@checked
def resume_campaign(
    folder: Path | str,
    engine: Engine | None = None,
    *,
    progress: Callable[[Progress], None] | None = None,
) -> CampaignFolder:
    """Plan what has no row yet.

    Args:
        folder: The folder of the campaign.
        engine: What plans: processes of this machine when None.
        progress: Called now and then, at least every second or so.

    Raises:
        MissingExtra: If pyarrow, or what the engine stands on, is not installed.
        CampaignError: If the folder holds no campaign or one of other versions, rows cannot be written, or
            workers cannot be started.
    """
    opened = CampaignFolder.open(folder)
    opened.check_versions()
    done = len(opened.done())
    if done < opened.total:
        with (engine or Local()).pool(opened) as pool:
            _Run(opened, pool, done, progress).go()
    return opened


class _Run:
    """One run of a campaign: what waits, what went wrong so far, and how fast it goes."""

    def __init__(
        self,
        folder: CampaignFolder,
        pool: Pool,
        done: int,
        progress: Callable[[Progress], None] | None,
    ) -> None:
        self._folder, self._pool, self._tell = folder, pool, progress
        self._missing: Iterator[Task] = folder.missing()
        self._left = folder.total - done
        self._again: deque[Block] = deque()
        self._running, self._failures, self._pace, self._exhausted = 0, 0, 0.0, False
        self._state, self._begun = Progress(done, folder.total), time.monotonic()

    def go(self) -> None:
        """Plan until every problem has its row.

        Raises:
            CampaignError: If rows cannot be written, or there are no workers any more.
        """
        while True:
            while self._pool.idle and (block := self._next()) is not None:
                self._running += 1
                self._pool.submit(block)
            if self._exhausted and not self._running and not self._again:
                return
            for ended in self._pool.wait(LOOK):
                self._running -= 1
                match ended:
                    case Planned():
                        self._keep(ended)
                    case Lost():
                        self._lost(ended)
            self._note(seconds=time.monotonic() - self._begun)

    def _next(self) -> Block | None:
        """Return what is handed to the next worker; None where nothing is left."""
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

    def _keep(self, ended: Planned) -> None:
        """Write the rows of a block; what cannot be written is planned again.

        Raises:
            CampaignError: If that happens several times in a row.
        """
        count = len(ended.block.tasks)
        self._pace = ended.seconds / count
        try:
            self._folder.write(ended.shard)
        except FileFormatError as error:
            self._failures += 1
            if self._failures >= FAILURES:
                raise CampaignError(
                    f"rows cannot be written: {error}; what was written before is kept: "
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
        """Hand a block to another worker, in halves: a problem that takes its machine down is found so."""
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
