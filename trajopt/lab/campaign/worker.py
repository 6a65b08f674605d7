"""A worker: a process that plans one problem after the other, and tells what became of some at once.

It talks over the socket whose number is its first argument, to the one process that started it, and ends when
that closes it. When it begins a problem it says so in the pipe whose number is its second: that is read only
when it ends or is late, so it wakes nobody.
"""

import ctypes
import os
import signal
import sys
import time
from collections.abc import Sequence
from multiprocessing.connection import Connection
from typing import cast

from trajopt.lab.campaign.campaign import Task
from trajopt.lab.campaign.columns import Row
from trajopt.lab.campaign.documents import Library
from trajopt.lab.campaign.kept import check_versions
from trajopt.lab.campaign.recipes import Workshop
from trajopt.lab.campaign.row import row_of
from trajopt.lab.campaign.setup import MARK, Bunch, Ready, Setup
from trajopt.values.errors import TrajoptError

BUNCH, BUNCH_SECONDS = 16, 0.25
"""Rows that are told at once, at most, and after how long those that are there are told [s]. Telling each by
itself costs half a millisecond of two processes, mostly in waking the other one; what is not told when the
worker ends is planned again. A quarter of what the worker is sent ahead, so that it has always more to do."""
DEATH_SIGNAL = 1
"""Linux' `PR_SET_PDEATHSIG`: a process is killed when its parent ends, however that ends."""


def serve(pipe: "Connection[object, object]", marks: int) -> None:
    """Plan what comes down the pipe until it is closed.

    Args:
        pipe: Where problems come from, and rows go to.
        marks: Number of the file where it is said that a problem begins.
    """
    try:
        setup = pipe.recv()
        assert isinstance(setup, Setup)
        try:
            check_versions(setup.versions, "the campaign")
        except TrajoptError as error:
            pipe.send(Ready(str(error)))
            return
        pipe.send(Ready())
        _plan(pipe, marks, setup)
    except (EOFError, BrokenPipeError, ConnectionResetError):
        pass  # whoever started this has ended


def _plan(pipe: "Connection[object, object]", marks: int, setup: Setup) -> None:
    """Plan what comes, for ever.

    Raises:
        EOFError: If the pipe is closed; or one of the errors of a pipe whose other end is.
    """
    shop, begun = Workshop(Library(setup.documents)), 0
    rows, waited, last = list[Row](), 0.0, time.monotonic()
    while True:
        if rows and not pipe.poll():  # whoever gives problems may wait for these rows
            pipe.send(Bunch(rows, waited))
            rows, waited, last = [], 0.0, time.monotonic()
        before = time.perf_counter()
        tasks = cast("Sequence[Task]", pipe.recv())
        if begun:  # the first one had to be started for
            waited += time.perf_counter() - before
        for task in tasks:
            begun += 1
            os.write(marks, MARK.pack(begun, time.monotonic()))
            rows.append(row_of(task, setup.options[task.options], shop))
            if len(rows) == BUNCH or time.monotonic() - last > BUNCH_SECONDS:
                pipe.send(Bunch(rows, waited))
                rows, waited, last = [], 0.0, time.monotonic()


def die_with_parent() -> None:
    """Have the system end this process when its parent ends, where it can: even in the midst of a core."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(DEATH_SIGNAL, signal.SIGKILL)


def main() -> None:
    """Serve the socket whose number is the first argument."""
    die_with_parent()
    with Connection(int(sys.argv[1])) as pipe:
        serve(pipe, int(sys.argv[2]))


if __name__ == "__main__":
    main()
