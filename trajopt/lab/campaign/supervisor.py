"""Worker processes of this machine: a problem that crashes or runs over time costs one row."""

import os
import signal
import socket
import subprocess
import time
from collections import deque
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from multiprocessing.connection import Connection, wait

from trajopt.lab.campaign import engine
from trajopt.lab.campaign.campaign import CampaignTask
from trajopt.lab.campaign.columns import Row, encoded
from trajopt.lab.campaign.kept import CampaignFolder
from trajopt.lab.campaign.row import Fate, lost_row
from trajopt.values.errors import CampaignError
from trajopt.values.errors.arguments import checked
from trajopt.values.processes import cores, start_worker

START = 120.0
"""Time-out of a worker's start [s]: trajopt may be imported from a slow disk."""
ATTEMPTS = 2
"""Crashes of a problem before it gets a row: one may be the machine's fault, such as low memory."""
PIPED, LETTERS = 64, 2**15
"""Most problems sent ahead, and most letters of their recipes beyond the first: a worker continues while
its supervisor is busy, and sending never blocks.
"""
ROOM = 2**18
"""Requested socket buffer [bytes]."""


@dataclass(frozen=True, eq=False)
class Worked:
    """Results of a block, and the time that the worker waited for problems [s]."""

    rows: Sequence[Row]
    waited: float


class WorkerSupervisor:
    """Manages one worker, passes blocks of problems to it, and writes the rows of crashed problems."""

    def __init__(self, setup: engine.Setup) -> None:
        self._setup = setup
        self._blocks: deque[Sequence[CampaignTask]] = deque()  # that are not yet returned
        self._unsent: deque[CampaignTask] = deque()
        self._sent: deque[CampaignTask] = deque()  # those that the worker has, and has not told of
        self._rows: dict[str, Row] = {}  # of the blocks, by id
        self._waited = 0.0
        self._deaths: dict[str, int] = {}
        self._killed = 0  # so often in a row before it was ready
        self._start()

    def give(self, block: Sequence[CampaignTask]) -> None:
        self._blocks.append(block)
        self._unsent += block
        if self._ready:
            self._hand_over()

    def advance(self) -> Worked | None:
        """Process messages of the worker, and check the deadline; return the results of a completed block."""
        try:
            while not self._whole and self.pipe.poll():
                self._take(self.pipe.recv())
        except (EOFError, OSError):
            self._died()
        if not self._whole and time.monotonic() > self.until:
            self._ran_over()
        if not self._whole:
            return None
        worked = Worked([self._rows.pop(task.id) for task in self._blocks.popleft()], self._waited)
        self._waited = 0.0
        return worked

    def run(self, block: Sequence[CampaignTask]) -> Worked:
        self.give(block)
        while (worked := self.advance()) is None:
            wait([self.pipe], timeout=max(0.0, min(self.until - time.monotonic(), 1.0)))
        return worked

    def close(self) -> None:
        self.pipe.close()
        self._marks.close()
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()

    @property
    def _whole(self) -> bool:
        if not self._blocks or len(self._rows) < len(self._blocks[0]):
            return False
        return all(task.id in self._rows for task in self._blocks[0])

    def _start(self) -> None:
        mine, its = socket.socketpair()
        read, written = os.pipe()
        os.set_blocking(read, False)
        self._marks = open(read, "rb", buffering=0)
        with its, open(written, "wb", buffering=0) as marks:
            for end in (mine, its):
                end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, ROOM)
                end.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, ROOM)
            self._process = start_worker("trajopt.lab.campaign.worker", its.fileno(), marks.fileno())
        self.pipe: Connection[object, object] = Connection(mine.detach())
        self._ready, self.until = False, time.monotonic() + START
        self._told = self._marked = 0  # problems that this worker told of, and began
        self._say(self._setup)

    def _hand_over(self) -> None:
        if len(self._sent) > PIPED // 2:
            return
        waits = not self._sent
        letters = sum(len(task.recipe) for task in islice(self._sent, 1, None))
        some: list[CampaignTask] = []
        while self._unsent and len(self._sent) < PIPED:
            letters += len(self._unsent[0].recipe) if self._sent else 0
            if letters > LETTERS:
                break
            some.append(self._unsent.popleft())
            self._sent.append(some[-1])
        if some:
            self._say(some)
        if waits:
            self._begin()

    def _say(self, what: object) -> None:
        try:
            self.pipe.send(what)
        except OSError:
            pass  # it has ended, which the next reading tells

    def _begin(self) -> None:
        self._read_marks()
        if self._marked <= self._told:
            self._begun = time.monotonic()
        self.until = self._begun + self._setup.most_seconds if self._sent else float("inf")

    def _read_marks(self) -> None:
        marks = self._marks.read(2 * PIPED * engine.MARK.size)
        if marks:
            self._marked, self._begun = engine.MARK.unpack(marks[-engine.MARK.size :])

    def _at(self) -> CampaignTask:
        self._read_marks()
        return self._sent[min(max(self._marked - self._told, 1), len(self._sent)) - 1]

    def _take(self, said: object) -> None:
        if isinstance(said, engine.StartReport):
            if said.reason:
                raise CampaignError(said.reason)
            self._ready, self._killed = True, 0
        elif isinstance(said, engine.Bunch):
            for row in said.rows:
                self._rows[self._sent.popleft().id] = row
            self._told += len(said.rows)
            self._waited += said.waited
        self._begin()
        self._hand_over()

    def _died(self) -> None:
        how = self._ending()
        if not self._ready:
            # A machine that lacks memory kills what has just begun; what ends by itself would do so again.
            self._killed += 1
            if self._process.returncode >= 0 or self._killed >= ATTEMPTS:
                raise CampaignError(f"a worker ended before it was ready ({how}); its output is above")
        elif self._sent:
            at = self._at()
            self._deaths[at.id] = self._deaths.get(at.id, 0) + 1
            if self._deaths[at.id] >= ATTEMPTS:
                self._give_up(at, Fate.CRASHED, how)
        self._again()

    def _ran_over(self) -> None:
        if not self._ready:
            raise CampaignError(f"a worker was not ready after {START:g} s")
        at = self._at()
        self.until = self._begun + self._setup.most_seconds
        if time.monotonic() <= self.until:
            return
        self._ending()
        self._give_up(at, Fate.RAN_OVER, f"{self._setup.most_seconds:g} s")
        self._again()

    def _give_up(self, task: CampaignTask, fate: Fate, why: str) -> None:
        self._sent.remove(task)
        self._rows[task.id] = lost_row(task, fate, why, time.monotonic() - self._begun)

    def _again(self) -> None:
        self._marks.close()
        self._unsent.extendleft(reversed(self._sent))
        self._sent.clear()
        self._start()

    def _ending(self) -> str:
        self.pipe.close()
        try:
            code = self._process.wait(1.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            code = self._process.wait()
        return f"signal {signal.Signals(-code).name}" if code < 0 else f"exit status {code}"


@checked
@dataclass(frozen=True)
class Local:
    """Processes of this machine; 0 workers for the number of usable cores."""

    workers: int = 0

    def __post_init__(self) -> None:
        engine.check_workers(self.workers)

    @contextmanager
    def pool(self, folder: CampaignFolder) -> Generator[engine.EnginePool]:
        workers = LocalPool(setup_of(folder), self.workers or cores())
        try:
            yield workers
        finally:
            workers.close()


class LocalPool:
    """Workers on this machine."""

    def __init__(self, setup: engine.Setup, workers: int) -> None:
        self._setup, self.workers = setup, workers
        self._blocks: dict[WorkerSupervisor, deque[engine.Block]] = {}

    @property
    def idle(self) -> int:
        return engine.AHEAD * self.workers - sum(map(len, self._blocks.values()))

    def submit(self, block: engine.Block) -> None:
        least = min(self._blocks, key=lambda each: len(self._blocks[each]), default=None)
        if least is None or (self._blocks[least] and len(self._blocks) < self.workers):
            least = WorkerSupervisor(self._setup)
            self._blocks[least] = deque()
        self._blocks[least].append(block)
        least.give(block.tasks)

    def wait(self, seconds: float) -> Sequence[engine.PlannedBlock | engine.Lost]:
        pipes = {each.pipe: each for each, blocks in self._blocks.items() if blocks}
        soonest = min((each.until for each in pipes.values()), default=0.0) - time.monotonic()
        ready = wait(list(pipes), timeout=max(0.0, min(seconds, soonest)))
        overdue = [each for each in pipes.values() if each.until < time.monotonic()]
        ended: list[engine.PlannedBlock | engine.Lost] = []
        for worker in dict.fromkeys((*(pipes[pipe] for pipe in ready), *overdue)):  # pyright: ignore
            while (worked := worker.advance()) is not None:  # what is told at once may end both of its blocks
                ended.append(planned(self._blocks[worker].popleft(), worked))
        return ended

    def close(self) -> None:
        for worker in self._blocks:
            worker.close()


def planned(block: engine.Block, worked: Worked) -> engine.PlannedBlock:
    rows = worked.rows
    busy = sum(row["cpu_seconds"]["total"] for row in rows if row.get("cpu_seconds"))
    seconds = sum(row["wall_seconds"] for row in rows)
    verified = sum(bool(row["verified"]) for row in rows)
    return engine.PlannedBlock(block, encoded(rows), seconds, busy, worked.waited, verified)


def setup_of(folder: CampaignFolder) -> engine.Setup:
    return engine.Setup(folder.documents, folder.options, folder.versions, folder.most_seconds)
