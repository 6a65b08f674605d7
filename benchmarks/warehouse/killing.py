"""Kill two writing processes by signal 9, and count acknowledged and stored entries."""

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from pathlib import Path
from threading import Thread
from typing import IO

from benchmarks.warehouse.writer import state
from trajopt.server.warehouse import Entry, StoredState, Warehouse
from trajopt.values.errors import TrajoptError

ROOT = Path(__file__).parents[2]
WRITERS = ("first", "second")


@dataclass(frozen=True)
class Found:
    """What was found after the kills.

    Attributes:
        kills: How often a process was killed.
        acknowledged: Writes that a process said were done.
        lost: Those of them that are not there.
        half: Entries that are there, but not as they were written.
        beyond: Whole entries of whose end no process could tell any more.
    """

    kills: int
    acknowledged: int
    lost: int
    half: int
    beyond: int


class Writer:
    """A writing process and its acknowledged writes."""

    def __init__(self, path: Path, who: str, count: int) -> None:
        """Start it."""
        self.who, self.said = who, list[str]()
        self.process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.warehouse.writer", str(path), who, str(count)],
            stdout=subprocess.PIPE,
            cwd=ROOT,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
        )
        assert self.process.stdout is not None
        self._thread = Thread(target=self._listen, args=(self.process.stdout,))
        self._thread.start()

    def _listen(self, out: IO[bytes]) -> None:
        for line in out:
            if line.endswith(b"\n"):  # a line that was cut off acknowledges nothing
                self.said.append(line.decode().strip())

    def ended(self, *, kill: bool) -> list[str]:
        """Wait for its end, immediate if it was killed; return its acknowledged writes."""
        if kill:
            self.process.send_signal(signal.SIGKILL)
        self.process.wait(timeout=120)
        self._thread.join()
        if self.process.stdout is not None:
            self.process.stdout.close()
        return self.said


def run(path: Path, *, writes: int, kills: int, seed: int) -> Found:
    """Let two processes write, kill one or both repeatedly, and check the warehouse.

    Args:
        path: The warehouse, which is made.
        writes: Of both processes together at least, of those that were acknowledged.
        kills: How often; each time both start anew.
        seed: Draws when and whom.
    """
    draw, said = random.Random(seed), set[tuple[str, ...]]()
    for turn in range(kills + 1):
        last = turn == kills
        share = ceil((writes - len(said)) / len(WRITERS)) if last else writes
        writers = [Writer(path, f"{who}{turn}", max(1, share)) for who in WRITERS]
        if not last:
            _wait(writers, draw.randint(1, max(1, writes // len(WRITERS) // (kills + 1))), draw)
        for each in writers:
            said |= {tuple(line.split()) for line in each.ended(kill=not last)}
    return _found(path, said, kills * len(WRITERS))


def _wait(writers: Sequence[Writer], count: int, draw: random.Random) -> None:
    """Wait until each has acknowledged so many writes, and a little longer: into the middle of the next.

    Raises:
        TimeoutError: If they do not get on.
    """
    begun = time.monotonic()
    while min(len(each.said) for each in writers) < count:
        if time.monotonic() - begun > 120.0:
            raise TimeoutError("the writers do not get on")
        time.sleep(0.001)
    time.sleep(draw.uniform(0.0, 0.01))


def _found(path: Path, acknowledged: set[tuple[str, ...]], kills: int) -> Found:
    there, half = set[tuple[str, ...]](), 0
    with Warehouse(path, create=False) as kept:
        for entry in kept.find():
            who, number = entry.tags[0], int(entry.note)
            half += not _whole(kept, entry, state(who, number))
            there.add((entry.note, entry.name.replace(" ", "_"), str(entry.version)))
    return Found(
        kills=kills,
        acknowledged=len(acknowledged),
        lost=len(acknowledged - there),
        half=half,
        beyond=len(there - acknowledged),
    )


def _whole(kept: Warehouse, entry: Entry, wanted: StoredState) -> bool:
    try:
        value: StoredState = kept.load(entry)
    except TrajoptError:
        return False
    return value.robot == wanted.robot and dict(value.positions) == dict(wanted.positions)
