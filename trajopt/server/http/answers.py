"""Requests read with bounds, and answers: JSON, or server-sent events with progress."""

import asyncio
from collections.abc import AsyncGenerator, Awaitable, Callable
from math import isfinite
from typing import Any

import msgspec
from fastapi import Request, Response
from fastapi.responses import StreamingResponse
from starlette.requests import ClientDisconnect

from trajopt.robot.robot import Robot
from trajopt.server.http.guard import JSON
from trajopt.server.job import Listener, Reply
from trajopt.server.limits import RequestRefused, Why
from trajopt.values.arrays import Floats
from trajopt.values.errors import TrajoptError

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
"""How HTTP calls each kind of refusal."""
EVENTS = "text/event-stream"
ALIVE = 15.0
"""Period of keep-alive messages, which reveal a lost client [s]."""
_ENCODER = msgspec.json.Encoder()
Asking = Callable[[Listener | None], Awaitable[Reply]]
"""Calls the service, with a listener for the progress."""


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
    """Return the body of a request."""
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
    """Call the service, and return the answer; a lost client cancels the request.

    Args:
        request: With `Accept: text/event-stream`, progress and answer are sent as events.
    """
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
    """Return numbers that JSON cannot hold as null: limits of joints may be infinite."""
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
