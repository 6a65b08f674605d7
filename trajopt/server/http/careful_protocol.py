"""HTTP as uvicorn speaks it, with patience for slow and silent clients that ends."""

import asyncio
import socket
from functools import partial
from typing import Any, cast

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from trajopt.server.http.options import HttpOptions


class CarefulProtocol(H11Protocol):
    """A connection that must say what it wants, and take what it gets, in time; else it is cut off."""

    def __init__(self, *args: Any, options: HttpOptions, **kwargs: Any) -> None:
        """Take uvicorn's arguments, and how slow a client may be."""
        super().__init__(*args, **kwargs)
        self._options = options
        self._head: asyncio.TimerHandle | None = None
        self._taking: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait for a request."""
        super().connection_made(transport)
        connected = cast("socket.socket", transport.get_extra_info("socket"))
        # A client whose machine is gone would never be missed otherwise.
        connected.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        if len(self.connections) > self._options.connections:
            transport.abort()
        else:
            self._expect()

    def data_received(self, data: bytes) -> None:
        """Take in what comes; a request's head has to come as a whole, in time."""
        super().data_received(data)
        if self.conn.their_state is not h11.IDLE:
            self._stop_waiting()
        elif self._head is None:
            self._expect()

    def pause_writing(self) -> None:
        """Wait for the client to take what is there for it."""
        super().pause_writing()
        self._taking = self.loop.call_later(self._options.transfer, self.transport.abort)

    def resume_writing(self) -> None:
        """Go on: it has taken some."""
        super().resume_writing()
        if self._taking is not None:
            self._taking.cancel()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait for nothing more."""
        self._stop_waiting()
        if self._taking is not None:
            self._taking.cancel()
        super().connection_lost(exc)

    def _expect(self) -> None:
        self._head = self.loop.call_later(self._options.head, self.transport.abort)

    def _stop_waiting(self) -> None:
        if self._head is not None:
            self._head.cancel()
            self._head = None


def careful_protocol(options: HttpOptions) -> type[asyncio.Protocol]:
    """Return what makes the protocol of each connection.

    Args:
        options: How slow a client may be, and how many connections there may be.
    """
    return cast("type[asyncio.Protocol]", partial(CarefulProtocol, options=options))
