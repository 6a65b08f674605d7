"""Stand-in for `rclpy.logging`: loggers that write to the logger `trajopt.ros.commander`."""

import logging

_LOG = logging.getLogger("trajopt.ros.commander")


class Logger:
    """A logger that prefixes its lines with a name."""

    def __init__(self, name: str) -> None:
        self.name = name

    def debug(self, message: str, **_: object) -> None:
        self._log(logging.DEBUG, message)

    def info(self, message: str, **_: object) -> None:
        self._log(logging.INFO, message)

    def warning(self, message: str, **_: object) -> None:
        self._log(logging.WARNING, message)

    warn = warning

    def error(self, message: str, **_: object) -> None:
        self._log(logging.ERROR, message)

    def fatal(self, message: str, **_: object) -> None:
        self._log(logging.CRITICAL, message)

    def _log(self, level: int, message: str) -> None:
        _LOG.log(level, "%s: %s", self.name, message)


def get_logger(name: str) -> Logger:
    return Logger(name)
