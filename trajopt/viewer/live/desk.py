"""Desk: one thread that does what a page is asked for, one thing after the other.

Whoever drags something asks more often than can be done. Of what has the same name only the last is done, and
nothing waits for what was asked before it. As all that changes what a page shows is done here, it needs no
lock.
"""

import logging
import threading
from collections.abc import Callable

from trajopt.values.errors import TrajoptError

LOG = logging.getLogger(__name__)


class Desk:
    """Does things in a thread of its own."""

    def __init__(self, complain: Callable[[str], None]) -> None:
        """Begin.

        Args:
            complain: Told, in that thread, why something could not be done.
        """
        self._complain = complain
        self._waiting: dict[str, Callable[[], None]] = {}
        self._working, self._closed = False, False
        self._news = threading.Condition()
        self._thread = threading.Thread(target=self._work, name="trajopt live page", daemon=True)
        self._thread.start()

    def do(self, name: str, work: Callable[[], None]) -> None:
        """Have something done soon, in place of what has the same name and still waits."""
        with self._news:
            self._waiting[name] = work
            self._news.notify_all()

    def settle(self, seconds: float) -> bool:
        """Wait until all is done, or the seconds are over; say whether it is."""
        with self._news:
            return self._news.wait_for(lambda: not self._waiting and not self._working, seconds)

    def close(self) -> None:
        """End the thread; what waits is not done any more."""
        with self._news:
            self._closed = True
            self._news.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join()

    def _work(self) -> None:
        """Do what waits, the oldest first (body of the thread)."""
        while True:
            with self._news:
                self._working = False
                self._news.notify_all()
                self._news.wait_for(lambda: bool(self._waiting) or self._closed)
                if self._closed:
                    return
                name = next(iter(self._waiting))
                work, self._working = self._waiting.pop(name), True
            try:
                work()
            except TrajoptError as error:
                self._complain(str(error))
            except Exception as error:  # a fault of the page must not leave it dead
                LOG.exception("the live page failed at %s", name)
                self._complain(f"a fault of this page ({type(error).__name__}: {error})")
