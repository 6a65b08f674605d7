"""Served: a page that is served until somebody closes it, or the program ends."""

import atexit
import threading
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

from trajopt.values.errors import shown
from trajopt.values.errors.arguments import checked
from trajopt.viewer.server import close_server

if TYPE_CHECKING:
    from trajopt.viewer.guarded_server import GuardedServer


class Served(ABC):
    """What all pages are: they have an address, can be waited for, and end.

    Attributes:
        url: Address of the page. It holds a secret: whoever has it can use the page.
    """

    def __init__(self, server: "GuardedServer") -> None:
        """Close the page when the program ends, if nobody does before."""
        self.url = server.address
        self._server, self._closed, self._closing = server, threading.Event(), threading.Lock()
        atexit.register(self.close)  # runs before viser's own, which would announce it

    @abstractmethod
    def _end(self) -> None:
        """End the page's own threads; nothing is drawn from then on."""

    @property
    def done(self) -> bool:
        """Whether the page is closed."""
        return self._closed.is_set()

    @checked
    def wait(self, seconds: float | None = None) -> None:
        """Block until Ctrl-C, until `close` is called, or until the seconds are over."""
        try:
            self._closed.wait(seconds)
        except KeyboardInterrupt:
            self.close()

    def close(self) -> None:
        """Stop serving the page."""
        with self._closing:
            if self._closed.is_set():
                return
            self._closed.set()
        atexit.unregister(self.close)
        self._end()
        close_server(self._server)

    def __repr__(self) -> str:
        """Say where the page is."""
        return f"{type(self).__name__}({shown(self.url)})"
