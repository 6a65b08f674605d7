"""Requests of the HTTP server: guarded and read with bounds; answers: JSON, or events with progress."""

import asyncio
import hmac
from collections.abc import AsyncGenerator, Awaitable, Callable
from dataclasses import dataclass
from ipaddress import ip_address
from math import isfinite
from typing import Any, TypeAlias

import msgspec
from fastapi import Request, Response
from fastapi.responses import StreamingResponse
from starlette.datastructures import Headers
from starlette.requests import ClientDisconnect
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from trajopt.robot.robot import Robot
from trajopt.server.job import Listener, Reply
from trajopt.server.limits import RequestRefused, Why
from trajopt.values.arrays import Floats, Value, at_least
from trajopt.values.errors import ProblemError, TrajoptError
from trajopt.values.errors.arguments import checked

STATUS = {
    Why.MALFORMED: 400,
    Why.UNKNOWN: 404,
    Why.TOO_LARGE: 413,
    Why.BUSY: 409,
    Why.FULL: 429,
    Why.OUT_OF_TIME: 408,
    Why.OUT_OF_MEMORY: 413,
    Why.WORKER_LOST: 500,
    Why.CANCELLED: 409,
    Why.CLOSING: 503,
    Why.FAILED: 500,
}
EVENTS = "text/event-stream"
ALIVE = 15.0
"""Period of keep-alive messages, which reveal a lost client [s]."""
_ENCODER = msgspec.json.Encoder()
Asking = Callable[[Listener | None], Awaitable[Reply]]


def json_bytes(document: object) -> bytes:
    return _ENCODER.encode(document)


def json_response(document: object, status: int = 200) -> Response:
    return Response(json_bytes(document), status, media_type=JSON)


def refusal_response(error: TrajoptError) -> Response:
    refusal = refusal_of(error)
    response = json_response(refusal.as_dict(), STATUS[refusal.why])
    if refusal.retry_after is not None:
        # Whole seconds are all that HTTP knows; the exact number is for clients that read it.
        response.headers["retry-after"] = str(max(1, round(refusal.retry_after)))
        response.headers["x-retry-after"] = f"{refusal.retry_after:.3f}"
    return response


def refusal_of(error: TrajoptError) -> RequestRefused:
    return error if isinstance(error, RequestRefused) else RequestRefused(Why.MALFORMED, str(error))


async def body_of(request: Request, most: int, seconds: float) -> bytes:
    too_large = RequestRefused(Why.TOO_LARGE, f"a request has {most} bytes at most")
    stated = request.headers.get("content-length", "0")
    if not stated.isdigit():
        raise RequestRefused(Why.MALFORMED, "content-length is not a number")
    if int(stated) > most:
        raise too_large
    parts, length = list[bytes](), 0
    try:
        async with asyncio.timeout(seconds):
            async for part in request.stream():
                length += len(part)
                if length > most:
                    raise too_large
                parts.append(part)
    except TimeoutError as error:
        raise RequestRefused(Why.OUT_OF_TIME, f"the request was not all there after {seconds:g} s") from error
    except ClientDisconnect as error:
        raise RequestRefused(Why.CANCELLED, "the client has gone") from error
    return b"".join(parts)


async def answered(request: Request, ask: Asking) -> Response:
    """Call the service, and return the answer; a lost client cancels the request."""
    if EVENTS in request.headers.get("accept", ""):
        return streamed(ask)
    task = asyncio.ensure_future(ask(None))
    gone = asyncio.ensure_future(_gone(request))
    try:
        await asyncio.wait((task, gone), return_when=asyncio.FIRST_COMPLETED)
        if not task.done():
            task.cancel()
        reply = await task
    except TrajoptError as error:
        return refusal_response(error)
    except asyncio.CancelledError:
        task.cancel()
        if gone.done() and not gone.cancelled():
            return refusal_response(RequestRefused(Why.CANCELLED, "the client has gone"))
        raise
    finally:
        gone.cancel()
    return Response(reply.body, media_type=JSON)


def streamed(ask: Asking) -> Response:
    headers = {"cache-control": "no-store", "x-accel-buffering": "no"}
    return StreamingResponse(_events(ask), media_type=EVENTS, headers=headers)


async def _gone(request: Request) -> None:
    while (await request.receive())["type"] != "http.disconnect":
        pass


async def _events(ask: Asking) -> AsyncGenerator[bytes]:
    told: asyncio.Queue[bytes] = asyncio.Queue()
    task = asyncio.ensure_future(ask(lambda raw: told.put_nowait(event("feedback", bytes(raw)))))
    task.add_done_callback(lambda _: told.put_nowait(b""))
    try:
        while True:
            try:
                async with asyncio.timeout(ALIVE):
                    said = await told.get()
            except TimeoutError:
                said = b":\n\n"
            if not said:
                break
            yield said
        try:
            yield event("answer", (await task).body)
        except TrajoptError as error:
            refusal = refusal_of(error)
            more = {"status": STATUS[refusal.why], "retry_after": refusal.retry_after}
            yield event("refusal", _ENCODER.encode({**refusal.as_dict(), **more}))
    finally:
        task.cancel()


def event(name: str, body: bytes) -> bytes:
    return b"event: %b\ndata: %b\n\n" % (name.encode(), body)


def plain(value: Any) -> Any:
    if isinstance(value, float) and value in (float("inf"), float("-inf")):
        return None
    return value


def robot_document(name: str, robot: Robot) -> dict[str, object]:
    """Return a robot as plain data for JSON; a missing limit is null."""
    limits = robot.limits
    return {
        "name": name,
        "joints": {
            joint: {
                "lower": _finite(limits.lower, place),
                "upper": _finite(limits.upper, place),
                "velocity": _finite(limits.velocity, place),
                "acceleration": _finite(limits.acceleration, place),
            }
            for place, joint in enumerate(robot.joint_names)
        },
        "groups": {key: list(group.joints) for key, group in robot.groups.items()},
        "states": [
            {"group": group, "name": state, "positions": dict(positions)}
            for (group, state), positions in robot.states.items()
        ],
        "links": list(robot.links),
        "frames": list(robot.frame_names),
    }


def _finite(values: Floats, place: int) -> float | None:
    value = float(values[place])
    return value if isfinite(value) else None


SHORTEST_TOKEN = 16
"""Characters of a token at least: fewer are guessed."""
LOCAL_NAMES = ("localhost", "127.0.0.1", "[::1]")
"""Names of this machine for local browsers and clients."""


def is_loopback(host: str) -> bool:
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


@checked
@dataclass(frozen=True, kw_only=True)
class HttpOptions(Value):
    """Address and access control of the server.

    Attributes:
        port: 0 for any free one.
        token: Required as `Authorization: Bearer TOKEN`; may be empty only on a loopback address.
    """

    host: str = "127.0.0.1"
    port: int = 8080
    token: str = ""
    names: tuple[str, ...] = ()
    connections: int = 512
    head: float = 10.0
    transfer: float = 30.0

    def __post_init__(self) -> None:
        if not self.token and not is_loopback(self.host):
            raise ProblemError(
                f"on {self.host} other machines can connect: give a token, or listen on 127.0.0.1"
            )
        if self.token and len(self.token) < SHORTEST_TOKEN:
            raise ProblemError(f"a token has {SHORTEST_TOKEN} characters at least")
        at_least(self, 0, "port")
        at_least(self, 1, "connections")

    @property
    def hosts(self) -> frozenset[str]:
        """Accepted host names, in lower case; all if a token is required."""
        return frozenset(name.lower() for name in (*LOCAL_NAMES, self.host, *self.names))


OPEN = ("/health", "/", "/page.js", "/page.css")
JSON, BYTES = "application/json", "application/octet-stream"
"""Accepted content types. A page of another site cannot send either without a preflight request."""
Denial: TypeAlias = tuple[int, str, str]


class RequestGuard:
    """Checks each request for its origin, host and token."""

    def __init__(self, app: ASGIApp, options: HttpOptions, attached: frozenset[str]) -> None:
        self._app, self._options, self._attached = app, options, attached

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        denial = self._denial(Headers(scope=scope), scope["method"], scope["path"])
        if denial is None:
            await self._app(scope, receive, send)
            return
        status, kind, reason = denial
        body = {"error": {"kind": kind, "reason": reason}}
        headers = {"www-authenticate": "Bearer"} if status == 401 else None
        await JSONResponse(body, status, headers)(scope, receive, send)

    def _denial(self, headers: Headers, method: str, path: str) -> Denial | None:
        options = self._options
        host = headers.get("host", "").lower()
        name = host.rpartition(":")[0] if host.rpartition(":")[2].isdigit() else host
        if not options.token and name not in options.hosts:
            return 421, "malformed", "the server is not known by that name"
        origin = headers.get("origin", "")
        if origin and origin.lower().partition("://")[2] != host:
            return 403, "malformed", "pages of other sites may not use the server"
        length = headers.get("content-length", "0")
        kind = headers.get("content-type", "").partition(";")[0].strip().lower()
        wanted = BYTES if path.rpartition("/")[2] in self._attached else JSON
        if method == "POST" and kind != wanted and (kind or length != "0"):
            return 415, "malformed", f"the request's body is {wanted}"
        if options.token and path not in OPEN and not self._knows(headers.get("authorization", "")):
            return 401, "malformed", "send the token: Authorization: Bearer TOKEN"
        return None

    def _knows(self, authorization: str) -> bool:
        scheme, _, token = authorization.partition(" ")
        right = hmac.compare_digest(token.encode(), self._options.token.encode())
        return right and scheme.lower() == "bearer"


AGAIN = 1.0
"""Delay before another try of a client that was refused for lack of memory [s]."""


class Intake:
    """Counts the bytes of bodies until their requests are answered; refuses those beyond the memory."""

    def __init__(self, app: ASGIApp, most: int) -> None:
        self._app, self._most, self.held = app, most, 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        mine = 0

        async def received() -> Message:
            nonlocal mine
            message = await receive()
            length = len(message.get("body", b""))
            if self.held + length > self._most:
                reason = f"the requests that are under way have {self._most} bytes at most together"
                raise RequestRefused(Why.FULL, reason, retry_after=AGAIN)
            mine += length
            self.held += length
            return message

        try:
            await self._app(scope, received, send)
        finally:
            self.held -= mine
