"""A worker watched by a clock: a problem that crashes or runs over costs one row, and the others go on."""

import os
import signal
import socket
import subprocess
import sys
import time
from collections import deque
from collections.abc import Sequence
from multiprocessing.connection import Connection, wait
from typing import cast

from trajopt.campaign.campaign import Task
from trajopt.campaign.columns import Row
from trajopt.campaign.row import Fate, lost_row
from trajopt.campaign.setup import Ready, Setup
from trajopt.errors import CampaignError

START = 120.0
"""A worker that is not ready after so long is given up [s]: it has to import trajopt from a slow disk."""
ATTEMPTS = 2
"""Times that a problem may end its process: once may be the machine's fault, such as too little memory."""
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""The libraries' own threads would take the cores of the other workers."""


class Supervisor:
    """Keeps one worker, gives it blocks of problems, and answers for those that it does not survive.

    Attributes:
        restarts: Processes that were started in place of one that had ended.
        waited: Wall-clock time that workers waited for a block after the first [s].
    """

    def __init__(self, setup: Setup) -> None:
        """Start a worker; it is not yet ready when this returns."""
        self._setup = setup
        self._waiting: deque[Task] = deque()
        self._rows: list[Row] = []
        self._deaths: dict[str, int] = {}
        self.restarts, self.waited, self._served = 0, 0.0, False
        self._start()

    @property
    def pid(self) -> int:
        """Id of the worker's process."""
        return self._process.pid

    @property
    def pipe(self) -> "Connection[object, object]":
        """What is ready to be read when the worker has said something, or has ended."""
        return self._pipe

    @property
    def until(self) -> float:
        """When it has to have said something, by the monotonic clock [s]."""
        return self._until

    def give(self, block: Sequence[Task]) -> None:
        """Hand over problems; there are none from before."""
        self._waiting, self._rows = deque(block), []
        if self._ready:
            self._hand_over()

    def advance(self) -> list[Row] | None:
        """Take what the worker says, if it says anything, and look at the clock.

        Returns:
            The rows of the block, once each of its problems has one; None before.

        Raises:
            CampaignError: If workers cannot be started.
        """
        try:
            while self._pipe.poll():
                self._take(self._pipe.recv())
        except (EOFError, OSError):
            self._died()
        if time.monotonic() > self._until:
            self._ran_over()
        if self._waiting or not self._rows:
            return None
        rows, self._rows = self._rows, []
        self._until = float("inf")
        return rows

    def run(self, block: Sequence[Task]) -> list[Row]:
        """Plan a block, and return its rows.

        Raises:
            CampaignError: If workers cannot be started.
        """
        self.give(block)
        rows: list[Row] | None = [] if not block else None
        while rows is None:
            wait([self._pipe], timeout=max(0.0, min(self._until - time.monotonic(), 1.0)))
            rows = self.advance()
        return rows

    def close(self) -> None:
        """End the worker, whatever it does, and wait until it has ended."""
        self._pipe.close()
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()

    def _start(self) -> None:
        mine, its = socket.socketpair()
        with its:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "trajopt.campaign.worker", str(its.fileno())],
                pass_fds=(its.fileno(),),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                start_new_session=True,  # the terminal's Ctrl-C is for whoever runs the campaign
                env={**os.environ, **dict.fromkeys(ONE_THREAD, "1"), "PYTHONPATH": os.pathsep.join(sys.path)},
            )
        self._pipe: Connection[object, object] = Connection(mine.detach())
        self._ready, self._until = False, time.monotonic() + START
        self._say(self._setup)

    def _hand_over(self) -> None:
        if self._waiting:
            self._say(list(self._waiting))
        self._begin()

    def _say(self, what: object) -> None:
        try:
            self._pipe.send(what)
        except OSError:
            pass  # it has ended, which the next reading tells

    def _begin(self) -> None:
        self._begun = time.monotonic()
        self._until = self._begun + self._setup.most_seconds if self._waiting else float("inf")

    def _take(self, said: object) -> None:
        if isinstance(said, Ready):
            if said.reason:
                raise CampaignError(said.reason)
            self._ready = True
            self._hand_over()
            return
        row, waited = cast("tuple[Row, float]", said)
        self.waited += waited if self._served else 0.0
        self._served = True
        self._waiting.popleft()
        self._rows.append(row)
        self._begin()

    def _died(self) -> None:
        """Note the death of the worker, and go on with another."""
        how = self._ending()
        if not self._ready:
            raise CampaignError(f"a worker ended before it was ready ({how}); what it said is above")
        if self._waiting:
            first = self._waiting[0]
            self._deaths[first.id] = self._deaths.get(first.id, 0) + 1
            if self._deaths[first.id] >= ATTEMPTS:
                self._give_up(Fate.CRASHED, how)
        self._again()

    def _ran_over(self) -> None:
        if not self._ready:
            raise CampaignError(f"a worker was not ready after {START:g} s")
        self._ending()
        self._give_up(Fate.RAN_OVER, f"{self._setup.most_seconds:g} s")
        self._again()

    def _give_up(self, fate: Fate, why: str) -> None:
        """Write the row of the problem that the worker was at."""
        task = self._waiting.popleft()
        self._rows.append(lost_row(task, fate, why, time.monotonic() - self._begun))

    def _again(self) -> None:
        """Start another worker, which is given what is left once it is ready."""
        self.restarts, self._served = self.restarts + 1, False
        self._start()

    def _ending(self) -> str:
        """End the worker if it has not ended, and say how it ended."""
        self._pipe.close()
        try:
            code = self._process.wait(1.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            code = self._process.wait()
        return f"signal {signal.Signals(-code).name}" if code < 0 else f"exit status {code}"
