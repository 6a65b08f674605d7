"""What a client sends and hears, without a server."""

import asyncio
import json
from collections.abc import Callable
from typing import Any

import httpx
import numpy as np
import pytest

from trajopt.server.client import AsyncClient, Call, Client, ServerError, Session
from trajopt.values.errors import TrajoptError

FULL = {"error": {"kind": "full", "reason": "8 requests wait already"}, "status": 429, "retry_after": 0.01}


def event(name: str, document: object) -> bytes:
    return f"event: {name}\ndata: {json.dumps(document)}\n\n".encode()


def crowded(times: int) -> tuple[httpx.MockTransport, list[int]]:
    """A server that is full so many times, and says so among its events, as it must once these have begun."""
    asked = list[int]()

    def answer(request: httpx.Request) -> httpx.Response:
        asked.append(len(asked))
        said = event("refusal", FULL) if len(asked) <= times else event("answer", {"done": True})
        return httpx.Response(200, content=event("feedback", {"on": 1}) + said)

    return httpx.MockTransport(answer), asked


def test_a_listening_client_also_retries_when_the_server_is_full() -> None:
    transport, asked = crowded(2)
    with Client("http://server") as client:
        client._http = httpx.Client(base_url="http://server", transport=transport)
        session = Session(client, "one", "arm")
        assert session.ask("wait", listener=lambda _: None) == {"done": True}
    assert len(asked) == 3


def test_who_listens_and_awaits_does_too() -> None:
    transport, asked = crowded(2)

    async def run() -> None:
        async with AsyncClient("http://server") as client:
            client._http = httpx.AsyncClient(base_url="http://server", transport=transport)
            assert await client.send(Call("POST", "/x", {}, lambda _: None)) == {"done": True}

    asyncio.run(run())
    assert len(asked) == 3


def test_a_server_that_stays_full_is_left_with_its_own_number() -> None:
    transport, _ = crowded(10**9)
    with Client("http://server", patience=0.03) as client:
        client._http = httpx.Client(base_url="http://server", transport=transport)
        with pytest.raises(ServerError, match="wait already") as refused:
            Session(client, "one", "arm").ask("wait", listener=lambda _: None)
    assert refused.value.status == 429


def test_arrays_go_out_as_lists() -> None:
    call = Call("POST", "/x", {"near": np.array([0.5, 1.0]), "count": np.int64(3), "in": (np.float64(2.0),)})
    assert json.loads(call.content["content"]) == {"near": [0.5, 1.0], "count": 3, "in": [2.0]}
    assert call.headers["content-type"] == "application/json"
    beside = Call("POST", "/x", {"positions": np.zeros(2), "name": "camera"}, data=b"")
    assert beside.parameters == {"positions": "[0.0, 0.0]", "name": "camera"}


@pytest.mark.parametrize("wrong", [float("nan"), np.array([np.inf]), object(), {1, 2}, lambda: 0])
@pytest.mark.parametrize("way", [lambda each: each.content, lambda each: each.parameters])
def test_names_the_field_that_is_not_plain_data(wrong: Any, way: Callable[[Call], object]) -> None:
    call = Call("POST", "/x", {"goal": wrong}, data=b"" if way.__code__.co_names == ("parameters",) else None)
    with pytest.raises(TrajoptError, match="goal"):
        way(call)
