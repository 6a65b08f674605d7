"""The log: a line of JSON for each thing that happens."""

import json
import logging
import sys
import time

from trajopt.server.requests import Done
from trajopt.server.session import SHOWN

_LOG = logging.getLogger("trajopt.server")
PLAIN = frozenset(vars(logging.makeLogRecord({}))) | {"message", "asctime", "taskName", "color_message"}
"""Standard attributes of a log record; the others are data."""


class JsonLines(logging.Formatter):
    """Writes a record as a line of JSON."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the line."""
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
