"""The HTTP application, and its numbers for Prometheus."""

import logging
import re
from collections.abc import Awaitable, Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from string import digits
from typing import Any, cast

from fastapi import FastAPI, Request, Response
from fastapi.responses import FileResponse
from prometheus_client import CollectorRegistry, Counter, Histogram, generate_latest
from prometheus_client.core import GaugeMetricFamily
from prometheus_client.registry import Collector
from starlette.exceptions import HTTPException
from starlette.types import Receive, Scope, Send

from trajopt.server.http.answers import (
    BYTES,
    JSON,
    STATUS,
    HttpOptions,
    Intake,
    RequestGuard,
    answered,
    body_of,
    json_bytes,
    json_response,
    refusal_response,
    robot_document,
    streamed,
)
from trajopt.server.job import Cancellation, Done
from trajopt.server.limits import RequestRefused, Why, memory_used
from trajopt.server.operation import Lane, Operation
from trajopt.server.pool import WorkerPool
from trajopt.server.service import Service
from trajopt.server.session import ServiceSession
from trajopt.values.documents.files import parse_json
from trajopt.values.errors import TrajoptError, shown

SECONDS = (0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0, 60.0)
"""Bounds of the histogram of durations, from kinematics to hard plans [s]."""


class Metrics:
    """Counts requests, and reads the state of a service on demand."""

    def __init__(self) -> None:
        self._registry = CollectorRegistry()
        labels = ("operation", "outcome")
        self._requests = Counter("trajopt_requests", "Requests", labels, registry=self._registry)
        self._seconds = Histogram(
            "trajopt_request_seconds", "Duration", labels[:1], registry=self._registry, buckets=SECONDS
        )
        self._cpu = Counter(
            "trajopt_request_cpu_seconds", "Processor time of workers", labels[:1], registry=self._registry
        )

    def of(self, service: Service) -> None:
        """Read a service."""
        self._registry.register(ServiceState(service))

    def count(self, done: Done) -> None:
        """Count a request that is over."""
        outcome = "answered" if done.why is None else done.why.name.lower()
        self._requests.labels(done.operation, outcome).inc()
        self._seconds.labels(done.operation).observe(done.seconds)
        self._cpu.labels(done.operation).inc(done.cpu)

    def text(self) -> bytes:
        """Return everything in Prometheus' format."""
        return generate_latest(self._registry)


NUMBERS: Mapping[str, tuple[str, Callable[[WorkerPool], int]]] = {
    "waiting": ("Requests that wait", lambda pool: pool.waiting),
    "busy": ("Workers at work", lambda pool: pool.busy),
    "workers": ("Workers that are up", lambda pool: len(pool.pids)),
    "restarts": ("Workers started in place of others", lambda pool: pool.restarts),
    "memory_bytes": ("Memory of workers", lambda pool: sum(memory_used(pid) for pid in pool.pids)),
}


class ServiceState(Collector):
    """The present state of a service."""

    def __init__(self, service: Service) -> None:
        self._service = service

    def collect(self) -> Iterator[GaugeMetricFamily]:
        lanes = {lane.name.lower(): pool for lane, pool in self._service.pools.items()}
        for name, (words, read) in NUMBERS.items():
            family = GaugeMetricFamily(f"trajopt_{name}", words, labels=["lane"])
            for lane, pool in lanes.items():
                family.add_metric([lane], float(read(pool)))
            yield family
        yield GaugeMetricFamily("trajopt_sessions", "Sessions", value=len(self._service.sessions))


_LOG = logging.getLogger("trajopt.server")
PAGES = Path(__file__).parent / "pages"
LONGEST_NAME = 64
VIEW_WORDS = (
    "Open a 3-D page of the session, of `group` if given. The answer is an event stream, and the page is "
    "open as long as it is read; the first `feedback` has `port` and `path` of the page, and `group`."
)
TIMEOUT = "timeout"
READ = "read"
"""The operation without arguments, and so no body."""
VIEW = "viewer/page"
"""The operation of the 3-D page; not reachable by clients, as only the server states its address."""
HOST_NAME = re.compile(r"[A-Za-z0-9.-]+")
"""Host names that a Content-Security-Policy can hold."""
DEFAULT = HttpOptions()
Body = dict[str, Any]


class Face:
    """The HTTP face of a service: FastAPI's routes, and faster ones for operations of workers."""

    def __init__(self, service: Service, options: HttpOptions, metrics: Metrics | None) -> None:
        self._service, self._options, self._metrics = service, options, metrics
        self._running: dict[tuple[str, str], Cancellation] = {}
        self.app = FastAPI(
            title="trajopt",
            description="Motions of robot arms, planned and proven. Errors: `{error: {kind, reason}}`.",
            docs_url=None,
            redoc_url=None,
        )
        self.app.add_exception_handler(TrajoptError, _refused)
        self.app.add_exception_handler(HTTPException, _no_such_thing)
        self.app.add_exception_handler(Exception, _fault)
        self._add("/health", self._health, "GET", "Whether the server does its work.")
        self._add("/metrics", self._numbers, "GET", "Numbers for Prometheus.")
        self._add("/robots", self._robots, "GET", "The robots: joints, limits, groups, states, frames.")
        self._add("/sessions", self._create, "POST", "Begin a session: `{robot}`, the first one if left out.")
        self._add(
            "/sessions/{session}",
            self._read,
            "GET",
            "Return the content of the scene, and the configuration of the robot.",
        )
        self._add(
            "/sessions/{session}/state",
            self._state,
            "GET",
            "Return the configuration of the robot, and changes.",
        )
        self._add("/sessions/{session}", self._close, "DELETE", "End a session.")
        self._add(
            "/sessions/{session}/fork", self._fork, "POST", "Create a session with the content of this one."
        )
        self._add("/sessions/{session}/view", self._view, "POST", VIEW_WORDS, body=JSON)
        self._add("/sessions/{session}/stop", self._stop, "POST", "Stop the robot that is being driven.")
        self._add(
            "/sessions/{session}/requests/{request_name}",
            self._cancel,
            "DELETE",
            "End a request with the header X-Request-Name; a plan answers with its best motion.",
        )
        self._described = {name for name in service.operations if name != READ and "/" not in name}
        for name in sorted(self._described):
            path = f"/sessions/{{session}}/{name}"
            operation = service.operations[name]
            kind = BYTES if operation.attached else JSON
            self._add(path, partial(self._ask, name), "POST", words_of(operation), body=kind)
        self.app.add_api_route("/", self._front, include_in_schema=False)
        for path, file in (("/docs", "docs.html"), ("/page.js", "page.js"), ("/page.css", "page.css")):
            self.app.add_api_route(path, partial(_page, file), include_in_schema=False)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        operation, session = worker_request(scope)
        if operation not in self._described:
            await self.app(scope, receive, send)
            return
        request = Request(scope, receive)
        try:
            response = await self._ask(operation, request, session)
        except TrajoptError as error:
            response = refusal_response(error)
        except Exception as error:
            _LOG.exception("a fault of the server")
            response = await _fault(request, error)
        await response(scope, receive, send)

    def _add(
        self,
        path: str,
        endpoint: Callable[..., Awaitable[Response]],
        method: str,
        words: str,
        *,
        body: str = "",
    ) -> None:
        extra: Body = {}
        if "{session}" in path:
            extra["parameters"] = [_path_parameter(name) for name in path.split("{")[1:]]
        if body:
            schema = {"type": "object"} if body == JSON else {"type": "string", "format": "binary"}
            extra["requestBody"] = {"content": {body: {"schema": schema}}}
        self.app.add_api_route(
            path,
            endpoint,
            methods=[method],
            summary=words.partition("\n")[0],
            description=words,
            name=f"{method} {path}",
            openapi_extra=extra,
            response_model=None,
        )

    async def _health(self) -> Response:
        pools = self._service.pools
        up = len(pools[Lane.PLANNING].pids)
        well = bool(up) and not self._service.closing
        return json_response({"healthy": well, "workers": up}, 200 if well else 503)

    async def _numbers(self) -> Response:
        text = b"" if self._metrics is None else self._metrics.text()
        return Response(text, media_type="text/plain; version=0.0.4")

    async def _robots(self) -> Response:
        return json_response([robot_document(name, robot) for name, robot in self._service.robots.items()])

    async def _create(self, request: Request) -> Response:
        document = await self._document(request)
        robot = document.pop("robot", "")
        if document or not isinstance(robot, str):
            raise RequestRefused(Why.MALFORMED, "a session begins with {robot: NAME}")
        return await self._begun(self._service.create(robot))

    async def _document(self, request: Request) -> Body:
        body = await body_of(request, 4096, self._options.transfer)
        try:
            document: object = parse_json(body.decode(), "request") if body else {}
        except UnicodeDecodeError as error:
            raise RequestRefused(Why.MALFORMED, "the request is not UTF-8 text") from error
        if not isinstance(document, dict):
            raise RequestRefused(Why.MALFORMED, "the request must be a mapping")
        return cast(Body, document)

    async def _begun(self, session: ServiceSession) -> Response:
        await self._service.keep(session)
        begun = {"session": session.id, "robot": session.robot, "revision": session.revision}
        return json_response(begun, 201)

    async def _read(self, request: Request, session: str) -> Response:
        held = self._service.sessions.get(session)
        return await answered(request, lambda told: self._service.ask(held, READ, listener=told))

    async def _state(self, session: str) -> Response:
        held = self._service.sessions.get(session)
        driven = held.run is not None
        return json_response({"revision": held.revision, "positions": held.positions, "driven": driven})

    async def _fork(self, session: str) -> Response:
        return await self._begun(self._service.fork(self._service.sessions.get(session)))

    async def _close(self, session: str) -> Response:
        await self._service.remove(session)
        return json_response({})

    async def _front(self, request: Request) -> Response:
        name = request.url.hostname or ""
        frames = [f"http://{name}:{port}" for port in self._view_ports] if HOST_NAME.fullmatch(name) else []
        return await _page("index.html", frames)

    @property
    def _view_ports(self) -> range:
        return range(self._options.port + 1, self._options.port + 1 + self._service.limits.views)

    async def _view(self, request: Request, session: str) -> Response:
        held = self._service.sessions.get(session)
        document = await self._document(request)
        group = document.pop("group", "")
        if document:
            raise RequestRefused(Why.MALFORMED, "a 3-D page is opened with {group: NAME}, or {}")
        ports = self._view_ports
        place = {"host": self._options.host, "first_port": ports[0], "last_port": ports[-1]}
        return streamed(lambda told: self._service.ask(held, VIEW, {"group": group, **place}, listener=told))

    async def _stop(self, session: str) -> Response:
        run = self._service.sessions.get(session).run
        if run is not None:
            run.cancel()
        return json_response({"stopping": run is not None})

    async def _cancel(self, session: str, request_name: str) -> Response:
        self._service.sessions.get(session)
        running = self._running.get((session, request_name))
        if running is None:
            raise RequestRefused(Why.UNKNOWN, "no request of that name is under way")
        running()
        return json_response({"cancelled": request_name})

    async def _ask(self, operation: str, request: Request, session: str) -> Response:
        held = self._service.sessions.get(session)
        seconds = _seconds(request.query_params.get(TIMEOUT))
        arguments = await body_of(request, self._service.limits.body, self._options.transfer)
        attachment = b""
        if self._service.operations[operation].attached:
            arguments, attachment = in_address(request), arguments
        elif unknown := sorted({*request.query_params} - {TIMEOUT}):
            raise RequestRefused(Why.MALFORMED, f"the address has {shown(unknown[0])}; it may have {TIMEOUT}")
        name = request.headers.get("x-request-name", "")[:LONGEST_NAME]
        cancellation = Cancellation()
        key = (session, name)

        async def ask(told: Any) -> Any:
            if name and self._running.setdefault(key, cancellation) is not cancellation:
                raise RequestRefused(Why.BUSY, "a request of that name is under way")
            try:
                return await self._service.ask(
                    held,
                    operation,
                    arguments,
                    attachment=attachment,
                    seconds=seconds,
                    listener=told,
                    cancellation=cancellation,
                )
            finally:
                if name:
                    del self._running[key]

        return await answered(request, ask)


def http_app(
    service: Service, options: HttpOptions = DEFAULT, metrics: Metrics | None = None
) -> RequestGuard:
    """Return the application of a service."""
    attached = frozenset(name for name, each in service.operations.items() if each.attached)
    return RequestGuard(Intake(Face(service, options, metrics), service.limits.bodies), options, attached)


def worker_request(scope: Scope) -> tuple[str, str]:
    if scope["type"] != "http" or scope["method"] != "POST":
        return "", ""
    match scope["path"].split("/"):
        case ["", "sessions", session, operation]:
            return operation, session
        case _:
            return "", ""


def in_address(request: Request) -> bytes:
    found: dict[str, bytes] = {}
    for key, text in request.query_params.multi_items():
        if key in found:
            raise RequestRefused(Why.MALFORMED, f"{shown(key)} is in the address twice")
        if key != TIMEOUT:
            found[key] = _as_json(text)
    return b"{%b}" % b",".join(json_bytes(key) + b":" + value for key, value in found.items())


def _as_json(text: str) -> bytes:
    if text.startswith(("{", "[", "-", *digits)):
        with suppress(TrajoptError):
            parse_json(text, "request")
            return text.encode()
    return json_bytes(text)


def words_of(operation: Operation) -> str:
    return " ".join((operation.run.__doc__ or "").split())


def _path_parameter(text: str) -> Body:
    return {"name": text.partition("}")[0], "in": "path", "required": True, "schema": {"type": "string"}}


def _seconds(text: str | None) -> float | None:
    if text is None:
        return None
    try:
        seconds = float(text)
    except ValueError:
        seconds = -1.0
    if not 0.0 < seconds < float("inf"):
        raise RequestRefused(Why.MALFORMED, "timeout is a number of seconds, more than 0")
    return seconds


async def _page(file: str, frames: Sequence[str] = ()) -> Response:
    framed = " ".join(frames) or "'none'"
    policy = f"default-src 'self'; img-src data:; frame-ancestors 'none'; frame-src {framed}"
    headers = {"content-security-policy": policy, "x-content-type-options": "nosniff"}
    return FileResponse(PAGES / file, headers=headers)


async def _refused(request: Request, error: Exception) -> Response:
    assert isinstance(error, TrajoptError)
    return refusal_response(error)


async def _no_such_thing(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    reason = "there is nothing at this address" if error.status_code == 404 else str(error.detail)
    allowed = (error.headers or {}).get("Allow", "")
    if allowed:
        reason = f"this address takes {allowed}, not {request.method}"
    response = json_response(RequestRefused(Why.UNKNOWN, reason).as_dict(), error.status_code)
    response.headers.update(error.headers or {})
    return response


async def _fault(request: Request, error: Exception) -> Response:
    refusal = RequestRefused(Why.FAILED, f"a fault of the server ({type(error).__name__})")
    return json_response(refusal.as_dict(), STATUS[refusal.why])
