"""A client of `trajopt serve`, blocking and asynchronous; it needs the extra `server` for httpx."""

import asyncio
import json
import time
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeAlias, TypeVar, cast
from urllib.parse import quote

import httpx
import numpy as np
from numpy.typing import ArrayLike

from trajopt.files.bundle.containers import value_of_message
from trajopt.files.moveit.trajectories import read_points
from trajopt.robot.robot import Robot
from trajopt.tasks.result import TaskResult
from trajopt.values.arrays import Value
from trajopt.values.documents.document import Node
from trajopt.values.errors import ProblemError, ShapeError, TrajoptError, shown
from trajopt.values.errors.arguments import checked, checked_class
from trajopt.values.trajectory import Trajectory


class ServerError(TrajoptError):
    """A request to a server failed.

    Attributes:
        retry_after: Delay before another try, as given by a full server [s]; None otherwise.
    """

    retry_after: float | None = None

    def __init__(self, status: int, kind: str, reason: str) -> None:
        self.status, self.kind, self.reason = status, kind, reason
        super().__init__(f"{kind}: {reason}")


Document: TypeAlias = dict[str, Any]
Listener: TypeAlias = Callable[[Document], None]
FULL = 429
AGAIN = "x-retry-after"
SHORTEST = 0.01
"""Shortest delay before another try [s]."""


@checked
def trajectory_of(answer: Mapping[str, Any]) -> Trajectory | None:
    """Return the motion in an answer of `plan` or `follow`, if any."""
    if not answer.get("points"):
        return None
    return read_points(Node({key: answer[key] for key in ("joint_names", "points")}, "answer"))


@checked
def task_result_of(answer: Mapping[str, Any], robot: Robot) -> TaskResult:
    """Return the result in an answer of `task` with `result=True`; its motions are judged here.

    Raises:
        FileFormatError: If the answer has no result, or a motion is not proven for this robot.
    """
    return value_of_message(Node(answer, "answer")["result"], {"robot": robot}, TaskResult)


def document_of(response: httpx.Response) -> Any:
    """Return the content of an answer; raise a ServerError for a refusal."""
    try:
        document = response.json()
    except ValueError:
        document = None
    if response.is_success and document is not None:
        return document
    after = response.headers.get(AGAIN, response.headers.get("retry-after", "1"))
    raise error_of(response.status_code, document, after)


def error_of(status: int, document: object, after: object) -> ServerError:
    stated: object = cast(Document, document).get("error") if isinstance(document, dict) else None
    if not isinstance(stated, dict):
        stated = {"kind": "failed", "reason": f"the server answered with status {status}"}
    members = cast(Document, stated)
    error = ServerError(status, str(members.get("kind")), str(members.get("reason")))
    if status == FULL and after is not None:
        error.retry_after = max(float(cast(str, after)), SHORTEST)
    return error


class _Retries:
    """Tries of a request, until a full server takes it or the patience is over [s]."""

    def __init__(self, server: httpx.URL, patience: float) -> None:
        self._server, self._until = server, time.monotonic() + patience

    def delay(self, error: httpx.HTTPError | ServerError) -> float:
        """Return the time until the next try [s]; raise the error if there is none."""
        if isinstance(error, httpx.HTTPError):
            reason = f"{self._server}: {str(error) or type(error).__name__}"
            raise ServerError(0, "unreachable", reason) from error
        if error.retry_after is None or time.monotonic() + error.retry_after > self._until:
            raise error
        return error.retry_after


class Events:
    """Server-sent events, line by line."""

    def __init__(self, listener: Listener) -> None:
        self._listener, self._name = listener, ""

    def take(self, line: str) -> Document | None:
        """Read a line; return the answer if it ends the events."""
        if line.startswith("event: "):
            self._name = line.removeprefix("event: ")
        if not line.startswith("data: "):
            return None
        document: Document = json.loads(line.removeprefix("data: "))
        if self._name == "answer":
            return document
        if self._name == "refusal":
            raise error_of(int(document.get("status", 200)), document, document.get("retry_after"))
        self._listener(document)
        return None


Reply = TypeVar("Reply")


@checked
@dataclass(frozen=True, eq=False)
class Call(Value):
    """An outgoing request.

    Attributes:
        path: Below the server's address.
        timeout: Time limit of the server [s]; its own limit if None.
        name: For cancellation; may be empty.
        data: Bytes instead of JSON; the arguments are then in the address.
    """

    method: str
    path: str
    body: Mapping[str, Any] | None = None
    listener: Listener | None = None
    timeout: float | None = None
    name: str = ""
    data: bytes | None = None

    @checked
    def request(self, http: httpx.Client | httpx.AsyncClient) -> httpx.Request:
        """Return it as a request of httpx."""
        return http.build_request(
            self.method, self.path, headers=self.headers, params=self.parameters, **self.content
        )

    @property
    def headers(self) -> dict[str, str]:
        """Headers of the request."""
        headers = {"x-request-name": self.name} if self.name else {}
        if self.data is not None:
            headers["content-type"] = "application/octet-stream"
        elif self.body is not None:
            headers["content-type"] = "application/json"
        return {**headers, "accept": "text/event-stream"} if self.listener is not None else headers

    @property
    def parameters(self) -> dict[str, str]:
        """Query parameters of the address."""
        stated = {} if self.timeout is None else {"timeout": f"{self.timeout:g}"}
        if self.data is None:
            return stated
        arguments = (self.body or {}).items()
        return stated | {key: each if isinstance(each, str) else _json(key, each) for key, each in arguments}

    @property
    def content(self) -> dict[str, Any]:
        """The body, as httpx accepts it."""
        if self.data is not None:
            return {"content": self.data}
        if self.body is None:
            return {}
        members = (f"{json.dumps(str(key))}:{_json(str(key), each)}" for key, each in self.body.items())
        return {"content": f"{{{','.join(members)}}}".encode()}


def _json(name: str, value: object) -> str:
    try:
        return json.dumps(value, default=_plain, allow_nan=False)
    except (TypeError, ValueError, RecursionError) as error:
        raise ProblemError(f"{name}: cannot be sent, as JSON does not hold it: {error}") from error


def _plain(value: object) -> object:
    if isinstance(value, np.ndarray | np.generic):
        return cast("object", value.tolist())
    raise TypeError(f"it has {shown(value)}")


def cloud_bytes(points: ArrayLike) -> bytes:
    """Return points in the server's format: float32 x, y, z, point by point [m]."""
    try:
        rows = np.asarray(points, dtype="<f4")
    except (TypeError, ValueError) as error:
        raise ShapeError("points", f"must be numbers, is {shown(points)}") from error
    if rows.size and (rows.ndim != 2 or rows.shape[1] != 3):
        raise ShapeError("points", f"needs shape (any, 3), has {rows.shape}")
    return rows.tobytes()


@checked_class
class SessionCalls(Generic[Reply]):
    """The requests of a session: a robot in a scene stored by the server.

    Arguments and answers are plain data, in the words of the Python API; docs/server.md has them.
    """

    def __init__(self, name: str, robot: str) -> None:
        self.id, self.robot = name, robot

    def __repr__(self) -> str:
        return f"{type(self).__name__}({shown(self.robot)}, id {shown(self.id)})"

    def _send(self, call: Call) -> Reply:
        raise NotImplementedError

    def ask(
        self,
        operation: str,
        arguments: Mapping[str, Any] | None = None,
        *,
        listener: Listener | None = None,
        timeout: float | None = None,
        name: str = "",
    ) -> Reply:
        """Request any operation, such as "plan"; `timeout` is the server's [s], `name` is for `cancel`.

        Raises:
            ServerError: If the server refuses it, or cannot be reached.
        """
        path = f"/sessions/{self.id}/{quote(operation, safe='')}"
        return self._send(Call("POST", path, arguments or {}, listener, timeout, name))

    def read(self) -> Reply:
        return self._send(Call("GET", f"/sessions/{self.id}"))

    def edit(self, edits: Sequence[Mapping[str, Any]]) -> Reply:
        """Change the scene: `[{"add": {"name": "post", "shape": {"box": {...}}}}]`; all edits or none."""
        return self.ask("edit", {"edits": list(edits)})

    def with_cloud(
        self,
        name: str,
        points: ArrayLike | None,
        *,
        radius: float | None = None,
        stamp: float | None = None,
        **sensed: Any,
    ) -> Reply:
        """Add a measured cloud to the scene, or replace the earlier cloud of that name.

        Args:
            points: Shape (n, 3) [m]; non-finite points are skipped. None for an empty measurement.
            radius: Of the ball of each point; the points are then in world coordinates [m].
            stamp: Time of the measurement on the sensor's clock [s]; older measurements than the newest are
                ignored.
            sensed: Without a radius the robot itself is removed, and the radius follows from these:
                `positions`, `frame`, `placement`, `nearest`, `farthest`, `spacing` as in
                `trajopt.lab.perception.PointCloud`, `cell`, `padding`, `sigmas`, `known` as in `Sensing`.

        Raises:
            ShapeError: If the points are invalid.
            ServerError: If the server refuses it, or cannot be reached.
        """
        stated = {"name": name, "radius": radius, "stamp": stamp, **sensed}
        arguments = {key: each for key, each in stated.items() if each is not None}
        path = f"/sessions/{self.id}/cloud"
        return self._send(Call("POST", path, arguments, data=b"" if points is None else cloud_bytes(points)))

    def motions(self, motions: Sequence[Mapping[str, Any]]) -> Reply:
        """Set the motions of objects: `[{"object": "box", "times": [...], "positions": [...]}]`."""
        return self.ask("motions", {"motions": list(motions)})

    def planning_scene(self, message: Mapping[str, Any]) -> Reply:
        """Send a `moveit_msgs/PlanningScene`: the whole scene, or, with `is_diff`, its changes."""
        return self.ask("planning_scene", message)

    def plan(
        self,
        problem: Mapping[str, Any],
        *,
        listener: Listener | None = None,
        timeout: float | None = None,
        name: str = "",
        **options: Any,
    ) -> Reply:
        """Plan a problem in the words of the Python API; `listener` receives each better motion.

        Args:
            options: `certificate`, `proof`, `seconds`, `improve`, `method`, `every_goal`, `free_duration`,
                `edits`.
        """
        arguments = {"problem": dict(problem), **options}
        return self.ask("plan", arguments, listener=listener, timeout=timeout, name=name)

    def task(
        self,
        task: Mapping[str, Any],
        *,
        listener: Listener | None = None,
        timeout: float | None = None,
        name: str = "",
        **options: Any,
    ) -> Reply:
        """Plan a task, written as for `trajopt.tasks.read_task`; `task_result_of` returns its result.

        Args:
            options: `result`, `seconds`, `improve`, `edits`.
        """
        arguments = {"task": dict(task), **options}
        return self.ask("task", arguments, listener=listener, timeout=timeout, name=name)

    def check(self, problem: Mapping[str, Any], trajectory: Mapping[str, Any]) -> Reply:
        return self.ask("check", {"problem": dict(problem), "trajectory": dict(trajectory)})

    def execute(
        self, problem: Mapping[str, Any], *, listener: Listener | None = None, **options: Any
    ) -> Reply:
        """Drive the simulated robot to a goal; the options are `speed`, `longest` and `edits`."""
        return self.ask("execute", {"problem": dict(problem), **options}, listener=listener)

    def stop(self) -> Reply:
        return self._send(Call("POST", f"/sessions/{self.id}/stop", {}))

    def cancel(self, name: str) -> Reply:
        """Cancel the request of that name; a plan answers with its best motion."""
        return self._send(Call("DELETE", f"/sessions/{self.id}/requests/{quote(name, safe='')}"))

    def close(self) -> Reply:
        return self._send(Call("DELETE", f"/sessions/{self.id}"))


@checked_class
class Client:
    """A client of `trajopt serve`."""

    def __init__(self, url: str, *, token: str = "", patience: float = 30.0, timeout: float = 120.0) -> None:
        """Store the address; no request is sent yet.

        Args:
            patience: Time for which requests to a full server are repeated [s].
            timeout: Time-out of a silent server [s].
        """
        headers = {"authorization": f"Bearer {token}"} if token else {}
        self._http = httpx.Client(base_url=url, headers=headers, timeout=timeout)
        self._patience = patience

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *raised: object) -> None:
        self.close()

    def close(self) -> None:
        self._http.close()

    def robots(self) -> list[Document]:
        """Return the robots: joints, limits, groups, states, frames."""
        return self.send(Call("GET", "/robots"))

    def session(self, robot: str = "") -> "Session":
        """Create a session with a robot, by default the server's first one."""
        begun = self.send(Call("POST", "/sessions", {"robot": robot}))
        return Session(self, begun["session"], begun["robot"])

    def resume(self, session: str) -> "Session":
        """Return an existing session by its id: of another client, or from before a restart."""
        return Session(self, session, self.send(Call("GET", f"/sessions/{quote(session, safe='')}"))["robot"])

    def send(self, call: Call) -> Any:
        """Send a request repeatedly while the server is full, and return the answer."""
        retries = _Retries(self._http.base_url, self._patience)
        while True:
            try:
                return self._once(call)
            except (httpx.HTTPError, ServerError) as error:
                delay = retries.delay(error)
            time.sleep(delay)

    def _once(self, call: Call) -> Any:
        response = self._http.send(call.request(self._http), stream=True)
        try:
            if call.listener is None or not response.is_success:
                response.read()
                return document_of(response)
            events = Events(call.listener)
            for line in response.iter_lines():
                if (answer := events.take(line)) is not None:
                    return answer
        finally:
            response.close()
        raise ServerError(0, "unreachable", "the server has gone in the midst of the request")


class Session(SessionCalls[Document]):
    """A robot in a scene that the server keeps; with `with` it ends with the block."""

    def __init__(self, client: Client, name: str, robot: str) -> None:
        super().__init__(name, robot)
        self._client = client

    def __enter__(self) -> "Session":
        return self

    def __exit__(self, *raised: object) -> None:
        self.close()

    def fork(self) -> "Session":
        begun = self._send(Call("POST", f"/sessions/{self.id}/fork", {}))
        return Session(self._client, begun["session"], begun["robot"])

    def _send(self, call: Call) -> Document:
        return self._client.send(call)


@checked_class
class AsyncClient:
    """A client of `trajopt serve`, all of whose answers are awaited."""

    def __init__(
        self,
        url: str,
        *,
        token: str = "",
        patience: float = 30.0,
        timeout: float = 120.0,
        connections: int = 100,
    ) -> None:
        """Store the address; arguments as for `Client`."""
        headers = {"authorization": f"Bearer {token}"} if token else {}
        most = httpx.Limits(max_connections=connections, max_keepalive_connections=connections)
        self._http = httpx.AsyncClient(base_url=url, headers=headers, timeout=timeout, limits=most)
        self._patience = patience

    async def __aenter__(self) -> "AsyncClient":
        return self

    async def __aexit__(self, *raised: object) -> None:
        await self.close()

    async def close(self) -> None:
        await self._http.aclose()

    async def robots(self) -> list[Document]:
        return await self.send(Call("GET", "/robots"))

    async def session(self, robot: str = "") -> "AsyncSession":
        begun = await self.send(Call("POST", "/sessions", {"robot": robot}))
        return AsyncSession(self, begun["session"], begun["robot"])

    async def resume(self, session: str) -> "AsyncSession":
        held = await self.send(Call("GET", f"/sessions/{quote(session, safe='')}"))
        return AsyncSession(self, session, held["robot"])

    async def send(self, call: Call) -> Any:
        """Send a request repeatedly while the server is full, and return the answer."""
        retries = _Retries(self._http.base_url, self._patience)
        while True:
            try:
                return await self._once(call)
            except (httpx.HTTPError, ServerError) as error:
                delay = retries.delay(error)
            await asyncio.sleep(delay)

    async def _once(self, call: Call) -> Any:
        response = await self._http.send(call.request(self._http), stream=True)
        try:
            if call.listener is None or not response.is_success:
                await response.aread()
                return document_of(response)
            events = Events(call.listener)
            async for line in response.aiter_lines():
                if (answer := events.take(line)) is not None:
                    return answer
        finally:
            await response.aclose()
        raise ServerError(0, "unreachable", "the server has gone in the midst of the request")


class AsyncSession(SessionCalls[Awaitable[Document]]):
    """A robot in a scene that the server keeps."""

    def __init__(self, client: AsyncClient, name: str, robot: str) -> None:
        super().__init__(name, robot)
        self._client = client

    async def fork(self) -> "AsyncSession":
        begun = await self._send(Call("POST", f"/sessions/{self.id}/fork", {}))
        return AsyncSession(self._client, begun["session"], begun["robot"])

    def _send(self, call: Call) -> Awaitable[Document]:
        return self._client.send(call)
