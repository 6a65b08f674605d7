"""A client of a rosbridge server; a thread reads its messages."""

from collections.abc import Callable
from contextlib import suppress
from threading import Thread

from websockets.exceptions import ConnectionClosed, WebSocketException
from websockets.sync.client import connect

from trajopt.ros.rosbridge.wire import Incoming, parsed, written
from trajopt.values.errors import ExecutionError, TrajoptError, shown


class RosbridgeClient:
    """A connection.

    Attributes:
        failure: Reason why the connection failed; empty while it works.
    """

    def __init__(self, url: str, *, timeout: float, heard: Callable[[Incoming], None]) -> None:
        """Connect.

        Args:
            url: Address of the server, such as "ws://robot:9090".
            timeout: Timeout of the server's answers [s].
            heard: Called by the reading thread with each operation of the server.

        Raises:
            ExecutionError: If no rosbridge server answers at the address.
        """
        try:
            self._socket = connect(url, open_timeout=timeout, close_timeout=timeout)
        except (OSError, WebSocketException, ValueError) as error:
            raise ExecutionError(f"cannot connect to {shown(url)}: {error}") from error
        self.failure, self._heard = "", heard
        self._reader = Thread(target=self._read, name="rosbridge", daemon=True)
        self._reader.start()

    def send(self, **operation: object) -> str:
        """Send an operation; return the reason if it cannot be sent."""
        if not self.failure:
            try:
                self._socket.send(written(operation).decode())
            except ConnectionClosed as error:
                self.failure = f"the connection to rosbridge is closed: {error}"
        return self.failure

    def close(self) -> None:
        """Close the connection, and wait until its reader has ended."""
        self.failure = self.failure or "the connection to rosbridge was closed here"
        with suppress(WebSocketException, OSError):
            self._socket.close()
        self._reader.join()

    def _read(self) -> None:
        try:
            for text in self._socket:
                self._heard(parsed(text))
        except ConnectionClosed as error:
            self.failure = self.failure or f"the connection to rosbridge is closed: {error}"
        except TrajoptError as error:
            self.failure = self.failure or f"rosbridge sent a message that cannot be read: {error}"
        self.failure = self.failure or "the rosbridge server has closed the connection"
