"""A worker as the server sees it: a process at the other end of a socket."""

import asyncio
import signal
import socket
import subprocess

import msgspec

from trajopt.server.limits import RequestRefused, Why
from trajopt.server.messages import FROM_WORKER, LENGTH, FromWorker, Hello, ToWorker, WorkerReady, framed
from trajopt.values.processes import start_worker

START = 120.0
READ_AT_ONCE = 2**20
"""Bytes of a worker's answer taken in before its reader is woken: most answers are shorter."""


class WorkerLost(Exception):
    """A worker has ended; the message describes how."""


class WorkerProcess:
    """A process that handles requests in sequence; `memory` is its memory when ready [bytes]."""

    def __init__(
        self,
        process: subprocess.Popen[bytes],
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
    ) -> None:
        self._process, self._reader, self._writer = process, reader, writer
        self.pid, self.memory = process.pid, 0

    @staticmethod
    async def started(hello: Hello) -> "WorkerProcess":
        """Start a worker, and wait until it has loaded its robots."""
        try:
            process, mine = _started()
        except OSError as error:
            raise WorkerLost(f"it could not be started: {error}") from error
        worker = None
        try:
            worker = WorkerProcess(process, *await asyncio.open_connection(sock=mine, limit=READ_AT_ONCE))
            worker.send(hello)
            ready = await asyncio.wait_for(worker.receive(), START)
            if not isinstance(ready, WorkerReady):
                raise WorkerLost("it did not report that it was ready")
        except BaseException as error:  # who starts it may be cancelled, and nobody else knows of it yet
            process.kill()
            process.wait()
            if worker is None:
                mine.close()
            else:
                await worker.close()
            if isinstance(error, TimeoutError):
                raise WorkerLost(f"it was not ready after {START:g} s") from error
            raise
        worker.memory = ready.memory
        return worker

    def send(self, message: ToWorker) -> None:
        self._writer.write(framed(message))

    async def receive(self) -> FromWorker:
        try:
            head = await self._reader.readexactly(LENGTH.size)
            return FROM_WORKER.decode(await self._reader.readexactly(LENGTH.unpack(head)[0]))
        except (asyncio.IncompleteReadError, ConnectionError, msgspec.DecodeError) as error:
            raise WorkerLost(await self._ending()) from error

    def kill(self) -> None:
        if self._process.poll() is None:
            self._process.kill()

    async def close(self) -> None:
        """End it, and wait until it has ended."""
        self._writer.close()
        self.kill()
        await asyncio.to_thread(self._process.wait)

    async def _ending(self) -> str:
        self.kill()  # a socket that is closed while the process lives is of no use either
        code = await asyncio.to_thread(self._process.wait)
        self._writer.close()
        return f"signal {signal.Signals(-code).name}" if code < 0 else f"exit status {code}"


def _started() -> tuple[subprocess.Popen[bytes], socket.socket]:
    mine, its = socket.socketpair()
    try:
        with its:
            process = start_worker("trajopt.server.worker", its.fileno())
    except BaseException:
        mine.close()
        raise
    return process, mine


def lost(error: WorkerLost) -> RequestRefused:
    return RequestRefused(Why.WORKER_LOST, f"the process that did it has ended ({error}); others go on")
