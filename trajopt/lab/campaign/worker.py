"""A worker process: it plans one problem after the other, and sends the rows in bunches."""

import os
import sys
import time
from collections.abc import Sequence
from multiprocessing.connection import Connection
from typing import cast

from trajopt.lab.campaign.campaign import CampaignTask
from trajopt.lab.campaign.columns import Row
from trajopt.lab.campaign.engine import MARK, Bunch, Setup, StartReport
from trajopt.lab.campaign.kept import check_versions
from trajopt.lab.campaign.recipes import Library, Workshop
from trajopt.lab.campaign.row import row_of
from trajopt.values.errors import TrajoptError
from trajopt.values.processes import die_with_parent

BUNCH, BUNCH_SECONDS = 16, 0.25
"""Most rows sent together, a quarter of the problems that the worker has in advance; and longest delay
[s].
"""


def serve(pipe: "Connection[object, object]", marks: int) -> None:
    """Plan problems from a pipe until it is closed; `marks` is the file of the marks at each start."""
    try:
        setup = pipe.recv()
        assert isinstance(setup, Setup)
        try:
            check_versions(setup.versions, "the campaign")
        except TrajoptError as error:
            pipe.send(StartReport(str(error)))
            return
        pipe.send(StartReport())
        _plan(pipe, marks, setup)
    except (EOFError, BrokenPipeError, ConnectionResetError):
        pass  # whoever started this has ended


def _plan(pipe: "Connection[object, object]", marks: int, setup: Setup) -> None:
    shop, begun = Workshop(Library(setup.documents)), 0
    rows, waited, last = list[Row](), 0.0, time.monotonic()
    while True:
        if rows and not pipe.poll():  # whoever gives problems may wait for these rows
            pipe.send(Bunch(rows, waited))
            rows, waited, last = [], 0.0, time.monotonic()
        before = time.perf_counter()
        tasks = cast("Sequence[CampaignTask]", pipe.recv())
        if begun:  # the first one had to be started for
            waited += time.perf_counter() - before
        for task in tasks:
            begun += 1
            os.write(marks, MARK.pack(begun, time.monotonic()))
            rows.append(row_of(task, setup.options[task.options], shop))
            if len(rows) == BUNCH or time.monotonic() - last > BUNCH_SECONDS:
                pipe.send(Bunch(rows, waited))
                rows, waited, last = [], 0.0, time.monotonic()


def main() -> None:
    """Serve the socket whose number is the first argument."""
    die_with_parent()
    with Connection(int(sys.argv[1])) as pipe:
        serve(pipe, int(sys.argv[2]))


if __name__ == "__main__":
    main()
