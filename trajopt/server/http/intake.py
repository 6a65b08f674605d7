"""What is taken in of requests: all that are under way together have a bound."""

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from trajopt.server.refusals import Refusal, Why

AGAIN = 1.0
"""Clients that are refused for want of room are told to come again after so long [s]."""


class Intake:
    """Counts the bytes of bodies, from when they come until their request is answered.

    Raises:
        Refusal: Where a body is read for which there is no room.
    """

    def __init__(self, app: ASGIApp, most: int) -> None:
        """Count what an application reads.

        Args:
            app: The application.
            most: Bytes that there may be of all requests together.
        """
        self._app, self._most, self._held = app, most, 0

    @property
    def held(self) -> int:
        """Bytes of the requests that are under way."""
        return self._held

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on."""
        mine = 0

        async def received() -> Message:
            nonlocal mine
            message = await receive()
            length = len(message.get("body", b""))
            if self._held + length > self._most:
                reason = f"the requests that are under way have {self._most} bytes at most together"
                raise Refusal(Why.FULL, reason, retry_after=AGAIN)
            mine += length
            self._held += length
            return message

        try:
            await self._app(scope, received, send)
        finally:
            self._held -= mine
