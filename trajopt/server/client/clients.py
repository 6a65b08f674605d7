"""The clients: one waits for each answer, the other is asynchronous."""

import asyncio
import time
from collections.abc import Awaitable
from types import TracebackType
from typing import Any
from urllib.parse import quote

import httpx

from trajopt.server.client.calls import (
    Call,
    Document,
    Events,
    ServerError,
    SessionCalls,
    again_after,
    document_of,
)
from trajopt.values.errors.arguments import checked


class Client:
    """A client of `trajopt serve`."""

    @checked
    def __init__(self, url: str, *, token: str = "", patience: float = 30.0, timeout: float = 120.0) -> None:
        """Store the address; no request is sent yet.

        Args:
            url: Its address, such as "http://127.0.0.1:8080".
            token: Access token.
            patience: Time for which requests to a full server are repeated [s].
            timeout: Time-out of a silent server [s].
        """
        headers = {"authorization": f"Bearer {token}"} if token else {}
        self._http = httpx.Client(base_url=url, headers=headers, timeout=timeout)
        self._patience = patience

    def __enter__(self) -> "Client":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close its connections."""
        self._http.close()

    def robots(self) -> list[Document]:
        """Return the robots: joints, limits, groups, states, frames."""
        return self.send(Call("GET", "/robots"))

    @checked
    def session(self, robot: str = "") -> "Session":
        """Create a session with a robot, by default the server's first one."""
        begun = self.send(Call("POST", "/sessions", {"robot": robot}))
        return Session(self, begun["session"], begun["robot"])

    @checked
    def resume(self, session: str) -> "Session":
        """Return an existing session by its id: of another client, or from before a restart.

        Raises:
            ServerError: If the server has none of that id.
        """
        return Session(self, session, self.send(Call("GET", f"/sessions/{quote(session, safe='')}"))["robot"])

    @checked
    def send(self, call: Call) -> Any:
        until = time.monotonic() + self._patience
        while True:
            try:
                answer, after = self._once(call)
            except httpx.HTTPError as error:
                raise ServerError(0, "unreachable", str(error) or type(error).__name__) from error
            except ServerError as error:
                if error.retry_after is None or time.monotonic() + error.retry_after > until:
                    raise
                answer, after = error, error.retry_after
            if after is None or time.monotonic() + after > until:
                return document_of(answer) if isinstance(answer, httpx.Response) else answer
            time.sleep(after)

    def _once(self, call: Call) -> tuple[httpx.Response | Document, float | None]:
        request = self._http.build_request(
            call.method, call.path, headers=call.headers, params=call.parameters, **call.content
        )
        response = self._http.send(request, stream=True)
        try:
            after = again_after(response)
            if call.listener is None or not response.is_success:
                response.read()
                return response, after
            events = Events(call.listener)
            for line in response.iter_lines():
                answer = events.take(line)
                if answer is not None:
                    return answer, None
        finally:
            response.close()
        raise ServerError(0, "unreachable", "the server has gone in the midst of the request")


class Session(SessionCalls[Document]):
    """A robot in a scene that the server keeps; with `with` it ends with the block."""

    def __init__(self, client: Client, name: str, robot: str) -> None:
        """Belong to a client."""
        super().__init__(name, robot)
        self._client = client

    def __enter__(self) -> "Session":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def fork(self) -> "Session":
        """Create another session with the present content of this one."""
        begun = self._send(Call("POST", f"/sessions/{self.id}/fork", {}))
        return Session(self._client, begun["session"], begun["robot"])

    def _send(self, call: Call) -> Document:
        return self._client.send(call)


class AsyncClient:
    """A client of `trajopt serve`, all of whose answers are awaited."""

    @checked
    def __init__(
        self,
        url: str,
        *,
        token: str = "",
        patience: float = 30.0,
        timeout: float = 120.0,
        connections: int = 100,
    ) -> None:
        """Store the address; no request is sent yet. Arguments as for `Client`.

        Args:
            connections: Largest number of simultaneous connections.
        """
        headers = {"authorization": f"Bearer {token}"} if token else {}
        most = httpx.Limits(max_connections=connections, max_keepalive_connections=connections)
        self._http = httpx.AsyncClient(base_url=url, headers=headers, timeout=timeout, limits=most)
        self._patience = patience

    async def __aenter__(self) -> "AsyncClient":
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        await self.close()

    async def close(self) -> None:
        """Close its connections."""
        await self._http.aclose()

    async def robots(self) -> list[Document]:
        """Return the robots: joints, limits, groups, states, frames."""
        return await self.send(Call("GET", "/robots"))

    @checked
    async def session(self, robot: str = "") -> "AsyncSession":
        """Create a session with a robot, by default the server's first one."""
        begun = await self.send(Call("POST", "/sessions", {"robot": robot}))
        return AsyncSession(self, begun["session"], begun["robot"])

    @checked
    async def resume(self, session: str) -> "AsyncSession":
        """Return an existing session by its id: of another client, or from before a restart.

        Raises:
            ServerError: If the server has none of that id.
        """
        held = await self.send(Call("GET", f"/sessions/{quote(session, safe='')}"))
        return AsyncSession(self, session, held["robot"])

    @checked
    async def send(self, call: Call) -> Any:
        """Send a request, again and again while the server is full, and return the answer.

        Raises:
            ServerError: If the server refuses it, or cannot be reached.
        """
        until = time.monotonic() + self._patience
        while True:
            try:
                answer, after = await self._once(call)
            except httpx.HTTPError as error:
                raise ServerError(0, "unreachable", str(error) or type(error).__name__) from error
            except ServerError as error:
                if error.retry_after is None or time.monotonic() + error.retry_after > until:
                    raise
                answer, after = error, error.retry_after
            if after is None or time.monotonic() + after > until:
                return document_of(answer) if isinstance(answer, httpx.Response) else answer
            await asyncio.sleep(after)

    async def _once(self, call: Call) -> tuple[httpx.Response | Document, float | None]:
        request = self._http.build_request(
            call.method, call.path, headers=call.headers, params=call.parameters, **call.content
        )
        response = await self._http.send(request, stream=True)
        try:
            after = again_after(response)
            if call.listener is None or not response.is_success:
                await response.aread()
                return response, after
            events = Events(call.listener)
            async for line in response.aiter_lines():
                answer = events.take(line)
                if answer is not None:
                    return answer, None
        finally:
            await response.aclose()
        raise ServerError(0, "unreachable", "the server has gone in the midst of the request")


class AsyncSession(SessionCalls[Awaitable[Document]]):
    """A robot in a scene that the server keeps."""

    def __init__(self, client: AsyncClient, name: str, robot: str) -> None:
        """Belong to a client."""
        super().__init__(name, robot)
        self._client = client

    async def fork(self) -> "AsyncSession":
        """Create another session with the present content of this one."""
        begun = await self._send(Call("POST", f"/sessions/{self.id}/fork", {}))
        return AsyncSession(self._client, begun["session"], begun["robot"])

    def _send(self, call: Call) -> Awaitable[Document]:
        return self._client.send(call)
