"""A server of pages on a port of this machine, opened without announcements."""

import atexit
import threading
from abc import ABC, abstractmethod
from contextlib import redirect_stdout
from io import StringIO
from socket import create_server
from typing import TYPE_CHECKING

from trajopt.values.arrays import one_of
from trajopt.values.errors import MissingExtra, ProblemError, shown
from trajopt.values.errors.arguments import checked

if TYPE_CHECKING:
    from viser import ViserServer

    from trajopt.viewer.guarded_server import GuardedServer

LAST_PORT = 65535


def open_server(host: str, port: int) -> "GuardedServer":
    """Serve an empty page, which opens only by the address with its secret."""
    try:
        import viser  # noqa: F401  # pyright: ignore[reportUnusedImport]

        from trajopt.viewer.guarded_server import GuardedServer
    except ImportError as error:
        raise MissingExtra("viser", "view") from error
    _check_address(one_of("host", host, str), port)
    with _unannounced():
        server = GuardedServer(host, port)
    server.gui.configure_theme(show_logo=False, show_share_button=False, brand_color=(0x44, 0x77, 0xAA))
    return server


def close_server(server: "ViserServer") -> None:
    with _unannounced():
        server.stop()


def _unannounced() -> redirect_stdout[StringIO]:
    return redirect_stdout(StringIO())


def _check_address(host: str, port: int) -> None:
    if type(port) is not int or not 0 <= port <= LAST_PORT:
        raise ProblemError(f"port must be a whole number from 0 to {LAST_PORT}, is {shown(port)}")
    try:
        create_server((host, 0)).close()
    except (OSError, UnicodeError) as error:
        raise ProblemError(f"view: nothing can be served on host {shown(host)}: {error}") from error


class Served(ABC):
    """Base of all pages: they have an address, can be waited for, and closed.

    Attributes:
        url: Address of the page. It contains a secret that grants access.
    """

    def __init__(self, server: "GuardedServer") -> None:
        self.url = server.address
        self._server, self._closed, self._closing = server, threading.Event(), threading.Lock()
        atexit.register(self.close)  # runs before viser's own, which would announce it

    @abstractmethod
    def _end(self) -> None:
        """End the page's own threads; nothing is drawn from then on."""

    @property
    def done(self) -> bool:
        return self._closed.is_set()

    @checked
    def wait(self, seconds: float | None = None) -> None:
        try:
            self._closed.wait(seconds)
        except KeyboardInterrupt:
            self.close()

    def close(self) -> None:
        with self._closing:
            if self._closed.is_set():
                return
            self._closed.set()
        atexit.unregister(self.close)
        self._end()
        close_server(self._server)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({shown(self.url)})"
