"""Ends a test that hangs inside compiled code, which pytest's own timeout cannot.

`timeout_method = "signal"` fails the one test that takes too long and goes on with the others. But its
handler is Python, and so waits for the compiled code to return; so would its method "thread", where that code
keeps the interpreter's lock. The timer of `faulthandler` is a thread in C: some seconds later it prints where
every thread is and ends the process. With pytest-xdist that is one worker, which is replaced.
"""

import faulthandler
import os
from collections.abc import Generator

import pytest

COPY = pytest.StashKey[int]()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addini("watchdog_grace", "Seconds that a test has after its timeout.", default="30")


def pytest_configure(config: pytest.Config) -> None:
    config.stash[COPY] = os.dup(2)  # while a test runs its output is captured, and would be lost


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    seconds = _timeout(item)
    if seconds > 0.0:
        grace = float(str(item.config.getini("watchdog_grace")))
        faulthandler.dump_traceback_later(seconds + grace, exit=True, file=item.config.stash[COPY])
    try:
        return (yield)
    finally:
        faulthandler.cancel_dump_traceback_later()


def _timeout(item: pytest.Item) -> float:
    """Return the test's own timeout, or else everybody's; 0 for none [s]."""
    marker = item.get_closest_marker("timeout")
    if marker is not None:
        return float(marker.args[0] if marker.args else marker.kwargs["timeout"])
    given = item.config.getoption("timeout")
    return float(str(item.config.getini("timeout")) or 0.0) if given is None else float(given)
