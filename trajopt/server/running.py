"""Running a service with all its faces, and its log: a line of JSON for each event."""

import asyncio
import json
import logging
import signal
import sys
import time
from collections.abc import Awaitable, Callable, Mapping, Sequence
from typing import TypeAlias

from trajopt.robot.robot import Robot
from trajopt.server.job import Done
from trajopt.server.limits import Limits
from trajopt.server.service import OPERATIONS, Service
from trajopt.server.session import SHOWN
from trajopt.server.warehouse import Warehouse

Face: TypeAlias = Callable[[Service, asyncio.Event], Awaitable[None]]
"""Serves a started service until an event is set: one protocol on one or several ports."""
SIGNALS = (signal.SIGINT, signal.SIGTERM)


async def run_faces(
    robots: Mapping[str, Robot],
    faces: Sequence[Face],
    *,
    limits: Limits,
    modules: tuple[str, ...] = (OPERATIONS,),
    observer: Callable[[Done], None] | None = None,
    warehouse: Warehouse | None = None,
) -> None:
    """Start a service and its faces, and end them when the process is told to, or a face fails.

    The service ends first: meanwhile its faces refuse new requests, and answer running ones.

    Args:
        modules: Modules with the operations that the faces need.
        observer: Called with each finished request.
        warehouse: Storage of sessions.

    Raises:
        OSError: If a face cannot listen on its address.
        RequestRefused: If the workers do not start.
    """
    told, stop, loop = asyncio.Event(), asyncio.Event(), asyncio.get_running_loop()
    for each in SIGNALS:
        loop.add_signal_handler(each, told.set)
    try:
        served = Service(robots, limits=limits, modules=modules, observer=observer, warehouse=warehouse)
        async with served as service:
            serving = [asyncio.ensure_future(face(service, stop)) for face in faces]
            waits = (*serving, asyncio.ensure_future(told.wait()))
            await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
            await service.close(drain=limits.grace)
            stop.set()
            await asyncio.gather(*serving)
    finally:
        for each in SIGNALS:
            loop.remove_signal_handler(each)


_LOG = logging.getLogger("trajopt.server")
PLAIN = frozenset(vars(logging.makeLogRecord({}))) | {"message", "asctime", "taskName", "color_message"}
"""Standard attributes of a log record; the others are data."""


class JsonLines(logging.Formatter):
    """Writes a record as a line of JSON."""

    def format(self, record: logging.LogRecord) -> str:
        stamp = time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(record.created))
        said: dict[str, object] = {
            "time": f"{stamp}.{int(record.msecs):03d}Z",
            "level": record.levelname.lower(),
            "event": record.getMessage(),
        }
        said.update((key, value) for key, value in vars(record).items() if key not in PLAIN)
        if record.exc_info:
            said["trace"] = self.formatException(record.exc_info)
        return json.dumps(said, default=str)


def write_log() -> None:
    """Write the log of the server and its libraries to standard error."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(JsonLines())
    for name in ("trajopt.server", "uvicorn", "websockets"):
        logger = logging.getLogger(name)
        logger.handlers, logger.propagate = [handler], False
        logger.setLevel(logging.INFO)


def log_request(done: Done) -> None:
    """Log a request that is over."""
    if not _LOG.isEnabledFor(logging.INFO):
        return
    said = {
        "operation": done.operation,
        "session": done.session[:SHOWN],
        "outcome": "answered" if done.why is None else done.why.value,
        "reason": done.reason,
        "waited": round(done.waited, 4),
        "seconds": round(done.seconds, 4),
        "cpu": round(done.cpu, 4),
    }
    # Made by hand: to look for the line that logs costs more than the rest, and it is always this one.
    record = _LOG.makeRecord(_LOG.name, logging.INFO, __file__, 0, "request", (), None, None, said)
    _LOG.handle(record)
