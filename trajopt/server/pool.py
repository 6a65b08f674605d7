"""A pool of workers with a bounded queue, fair between sessions."""

import asyncio
import logging
from collections import OrderedDict, deque
from contextlib import suppress
from itertools import count
from typing import Generic, TypeVar

from trajopt.server.job import Assignment, Job
from trajopt.server.limits import Limits, RequestRefused, Why
from trajopt.server.messages import Answered, Feedback, FromWorker, Hello, Rejected
from trajopt.server.worker_process import WorkerLost, WorkerProcess, lost

_LOG = logging.getLogger("trajopt.server")
AGAIN = 1.0
"""Delay before another start of a failed worker [s], equal to the retry delay of clients."""
MEMORY = 0.01
"""Weight of the newest request in the mean duration: about a hundred requests count."""


class WorkerPool:
    """Workers and their waiting requests."""

    def __init__(
        self,
        name: str,
        hello: Hello,
        size: int,
        limits: Limits,
        *,
        eager: bool = True,
    ) -> None:
        self.restarts = self.busy = 0
        self._name, self._hello, self.size, self._limits = name, hello, size, limits
        self._eager = eager
        self._queue: FairQueue[Job] = FairQueue()
        self._slots: list[asyncio.Task[None]] = []
        self._closed = False
        self._workers: dict[int, WorkerProcess] = {}
        self._up, self._numbers, self._mean = asyncio.Semaphore(0), count(1), 0.0

    @property
    def waiting(self) -> int:
        return len(self._queue)

    @property
    def pids(self) -> tuple[int, ...]:
        return tuple(self._workers)

    async def start(self) -> None:
        self._slots = [asyncio.create_task(self._slot()) for _ in range(self.size)]
        if self._eager:
            up = asyncio.gather(*(self._up.acquire() for _ in self._slots))
            await asyncio.wait((up, *self._slots), return_when=asyncio.FIRST_COMPLETED)
            if not up.done():
                up.cancel()
                raise next(error for slot in self._slots if slot.done() and (error := slot.exception()))

    async def close(self) -> None:
        self._closed = True
        for slot in self._slots:
            slot.cancel()
        await asyncio.gather(*self._slots, return_exceptions=True)
        while self.waiting:
            (await self._queue.take()).refuse(_closing())

    def submit(self, owner: str, assignment: Assignment) -> Job:
        if self._closed:
            raise _closing()
        if self._queue.of(owner) >= self._limits.waiting_per_session:
            raise self._full(f"{self._queue.of(owner)} requests of this session wait already")
        if self.waiting >= self._limits.waiting:
            raise self._full(f"{self.waiting} requests wait already")
        job = Job(next(self._numbers), owner, assignment, self._limits.grace)
        job.done.add_done_callback(lambda _: self._queue.discard(owner, job))
        self._queue.put(owner, job)
        return job

    def _full(self, reason: str) -> RequestRefused:
        wait = max(self._mean * self.waiting / self.size, 0.05)
        return RequestRefused(Why.FULL, reason, retry_after=wait)

    async def _slot(self) -> None:
        worker: WorkerProcess | None = None
        try:
            if self._eager:
                worker = await self._started()
                self._up.release()
            while True:
                job = await self._queue.take()
                try:
                    worker = worker or await self._started()
                except WorkerLost as error:
                    job.refuse(lost(error))
                    await asyncio.sleep(AGAIN)
                    continue
                except asyncio.CancelledError:
                    job.refuse(_closing())
                    raise
                if not await self._served(worker, job):
                    self._workers.pop(worker.pid)
                    await worker.close()
                    worker, self.restarts = None, self.restarts + 1
                    with suppress(WorkerLost):
                        worker = await self._started() if self._eager else None
        finally:
            if worker is not None:
                self._workers.pop(worker.pid, None)
                await worker.close()

    async def _started(self) -> WorkerProcess:
        worker = await WorkerProcess.started(self._hello)
        self._workers[worker.pid] = worker
        _LOG.info("worker ready", extra={"pool": self._name, "pid": worker.pid})
        return worker

    async def _served(self, worker: WorkerProcess, job: Job) -> bool:
        if job.over:
            return True
        self.busy += 1
        job.begin(worker)
        try:
            said = await worker.receive()
            while isinstance(said, Feedback):
                job.tell(said)
                said = await worker.receive()
            return self._finished(worker, job, said)
        except WorkerLost as error:
            _LOG.warning("worker lost", extra={"pool": self._name, "pid": worker.pid, "ended": str(error)})
            self._over(job, lost(error))
            return False
        except asyncio.CancelledError:
            self._over(job, _closing())
            raise
        finally:
            self.busy -= 1

    def _finished(self, worker: WorkerProcess, job: Job, said: FromWorker) -> bool:
        match said:
            case Answered():
                self._over(job, said)
            case Rejected():
                self._over(job, RequestRefused(Why(said.why), said.reason))
            case _:
                raise WorkerLost(f"it sent {type(said).__name__} at the end of a request")
        return said.memory - worker.memory < self._limits.memory // 2

    def _over(self, job: Job, ended: Answered | RequestRefused) -> None:
        taken = asyncio.get_running_loop().time() - job.begun
        self._mean += (taken - self._mean) * (MEMORY if self._mean else 1.0)
        if isinstance(ended, Answered):
            job.answer(ended)
        else:
            job.refuse(ended)


def _closing() -> RequestRefused:
    return RequestRefused(Why.CLOSING, "the server is closing")


Item = TypeVar("Item")


class FairQueue(Generic[Item]):
    """Items with owners: owners take turns, and each owner's items keep their order."""

    def __init__(self) -> None:
        self._waiting: OrderedDict[object, deque[Item]] = OrderedDict()
        self._there = asyncio.Semaphore(0)

    def __len__(self) -> int:
        return sum(map(len, self._waiting.values()))

    def of(self, owner: object) -> int:
        return len(self._waiting.get(owner, ()))

    def put(self, owner: object, item: Item) -> None:
        self._waiting.setdefault(owner, deque()).append(item)
        self._there.release()

    def discard(self, owner: object, item: Item) -> bool:
        line = self._waiting.get(owner)
        if line is None or item not in line:
            return False
        line.remove(item)
        if not line:
            del self._waiting[owner]
        return True

    async def take(self) -> Item:
        while True:
            await self._there.acquire()
            if not self._waiting:
                continue  # what was added has been taken out
            owner, line = self._waiting.popitem(last=False)
            item = line.popleft()
            if line:
                self._waiting[owner] = line
            return item
