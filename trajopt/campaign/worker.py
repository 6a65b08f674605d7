"""A worker: a process that plans one problem after the other, and tells what became of each.

It talks over the socket whose number is its argument, to the one process that started it, and ends when that
closes it.
"""

import ctypes
import signal
import sys
import time
from multiprocessing.connection import Connection

from trajopt.campaign.campaign import Task
from trajopt.campaign.documents import Library
from trajopt.campaign.kept import check_versions
from trajopt.campaign.recipes import Workshop
from trajopt.campaign.row import row_of
from trajopt.campaign.setup import Ready, Setup
from trajopt.errors import TrajoptError

DEATH_SIGNAL = 1
"""Linux' `PR_SET_PDEATHSIG`: a process is killed when its parent ends, however that ends."""


def serve(pipe: "Connection[object, object]") -> None:
    """Plan what comes down the pipe until it is closed."""
    try:
        setup = pipe.recv()
        assert isinstance(setup, Setup)
        try:
            check_versions(setup.versions, "the campaign")
        except TrajoptError as error:
            pipe.send(Ready(str(error)))
            return
        pipe.send(Ready())
        shop = Workshop(Library(setup.documents))
        served = False
        while True:
            before = time.perf_counter()
            task = pipe.recv()
            waited = time.perf_counter() - before if served else 0.0  # the first one had to be started for
            assert isinstance(task, Task)
            pipe.send((row_of(task, setup.options[task.options], shop), waited))
            served = True
    except (EOFError, BrokenPipeError, ConnectionResetError):
        pass  # whoever started this has ended


def die_with_parent() -> None:
    """Have the system end this process when its parent ends, where it can: even in the midst of a core."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(DEATH_SIGNAL, signal.SIGKILL)


def main() -> None:
    """Serve the socket whose number is the argument."""
    die_with_parent()
    with Connection(int(sys.argv[1])) as pipe:
        serve(pipe)


if __name__ == "__main__":
    main()
