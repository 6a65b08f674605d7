"""Robots, sessions and workers, behind every face of the server; without a protocol."""

import asyncio
import json
import logging
import pickle
import signal
import sys
import time
from collections.abc import Awaitable, Callable, Generator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from typing import Any, TypeAlias, cast

import msgspec

from trajopt.robot.configuration import initial_positions
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.server.job import Assignment, Cancellation, Done, Job, Listener, Reply, counted
from trajopt.server.limits import Limits, RequestRefused, Why
from trajopt.server.messages import Answered, Hello
from trajopt.server.operation import Lane, Operation, PackedScene, SessionState, operations_of, packed
from trajopt.server.pool import WorkerPool
from trajopt.server.session import SHOWN, Keeper, ServiceSession, Sessions
from trajopt.server.warehouse import Warehouse
from trajopt.server.worker_process import WorkerLost
from trajopt.values.errors import ProblemError, RobotNotFound, listed, shown
from trajopt.values.errors.arguments import checked_class

OPERATIONS = "trajopt.server.operations"
DEFAULT = Limits()
_JSON = msgspec.json.Encoder()


@checked_class
class Service:
    """Robots, sessions and workers, some in each lane; `async with` starts and ends them."""

    def __init__(
        self,
        robots: Mapping[str, Robot],
        *,
        limits: Limits = DEFAULT,
        modules: tuple[str, ...] = (OPERATIONS,),
        observer: Callable[[Done], None] | None = None,
        warehouse: Warehouse | None = None,
    ) -> None:
        """Store the options; each module has `OPERATIONS`. There is at least one robot."""
        if not robots:
            raise ProblemError("a service needs at least one robot")
        self.robots, self.limits, self.sessions = dict(robots), limits, Sessions(limits)
        self.operations: Mapping[str, Operation] = operations_of(modules)
        pickled = {name: pickle.dumps(robot) for name, robot in robots.items()}
        hello = Hello(pickled, modules, limits.memory, limits.triangles, limits.points, limits.cloud)
        self.pools = {
            Lane.PLANNING: WorkerPool("planning", hello, limits.workers, limits),
            Lane.QUICK: WorkerPool("quick", hello, 1, limits),
            Lane.DRIVING: WorkerPool("driving", hello, limits.runs, limits, eager=False),
            Lane.VIEWING: WorkerPool("viewing", hello, limits.views, limits, eager=False),
        }
        self._keeper = None if warehouse is None else Keeper(warehouse, hello, limits)
        if self._keeper is not None:
            self.pools[Lane.KEEPING] = self._keeper.pool
        self._observer, self._closing = observer, False
        self._asking, self._driving = set[asyncio.Task[Any]](), dict[asyncio.Task[Answered], Job]()
        self._empty: dict[str, tuple[PackedScene, list[float]]] = {}

    async def __aenter__(self) -> "Service":
        if self._keeper is not None:
            self._keeper.claim()
        try:
            await asyncio.gather(*(pool.start() for pool in self.pools.values()))
            if self._keeper is not None:
                empty = {name: self._empty_scene(name) for name in self.robots}
                for session in await self._keeper.restored(empty, self.limits.sessions):
                    self.sessions.put(session)
        except BaseException as error:
            await self.close(drain=0.0)
            if isinstance(error, WorkerLost):
                raise RequestRefused(Why.WORKER_LOST, f"a worker did not come up: {error}") from error
            raise
        return self

    async def __aexit__(self, *raised: object) -> None:
        await self.close(drain=self.limits.grace)

    async def close(self, *, drain: float) -> None:
        self._closing = True
        for run in self._driving.values():
            run.cancel(RequestRefused(Why.CLOSING, "the server is closing, and has stopped the robot"))
        if drain and (under_way := self._asking | self._driving.keys()):
            await asyncio.wait(under_way, timeout=drain)
        await asyncio.gather(*(pool.close() for pool in self.pools.values()))
        await asyncio.gather(*self._driving, return_exceptions=True)
        if self._keeper is not None:
            self._keeper.release()

    @property
    def closing(self) -> bool:
        """Whether further requests are refused."""
        return self._closing

    def create(self, robot: str = "", *, face: str = "") -> ServiceSession:
        """Create a session: a robot in an empty world, each group in its first named state.

        Args:
            face: Name of the face that owns it, if any: such a session is kept although unused, and is found
                again after a restart if it was stored.

        Raises:
            RobotNotFound: If there is no such robot.
            RequestRefused: If there are too many sessions, or the server is closing.
        """
        self._check_open()
        name = robot or next(iter(self.robots))
        if name not in self.robots:
            raise RobotNotFound("robot", name, self.robots)
        known = self.sessions.of_face(face, name) if face else None
        return known or self.sessions.add(*self._empty_scene(name), face=face)

    def _empty_scene(self, name: str) -> tuple[PackedScene, list[float]]:
        if name not in self._empty:
            loaded = self.robots[name]
            state = SessionState(name, Scene(loaded), initial_positions(loaded))
            self._empty[name] = packed(state, self.robots), state.positions.tolist()
        return self._empty[name]

    def fork(self, session: ServiceSession) -> ServiceSession:
        """Create a session with the present content of another.

        Raises:
            RequestRefused: If there are too many sessions, or the server is closing.
        """
        self._check_open()
        return self.sessions.add(session.scene, session.positions, stamps=session.stamps)

    async def keep(self, session: ServiceSession) -> None:
        """Have a session be there after a restart too, changed or not; without a warehouse it cannot."""
        if self._keeper is not None:
            await self._keeper.keep(session, session.scene, session.positions)
            await self._forgotten()

    async def remove(self, name: str) -> None:
        self.sessions.remove(name)
        await self._forgotten()

    async def _forgotten(self) -> None:
        for session in self.sessions.taken_gone():
            if self._keeper is not None:
                await self._keeper.forget(session)

    async def ask(
        self,
        session: ServiceSession,
        operation: str,
        arguments: bytes | Mapping[str, Any] = b"{}",
        *,
        attachment: bytes = b"",
        seconds: float | None = None,
        listener: Listener | None = None,
        cancellation: Cancellation | None = None,
    ) -> Reply:
        """Run an operation, and wait for the answer. Cancelling this coroutine cancels the request."""
        with self._asked(), counted(session.id, operation, self._observer) as done:
            found = self.operations.get(operation)
            if found is None:
                raise RequestRefused(
                    Why.UNKNOWN, f"no operation {shown(operation)}; known: {listed(sorted(self.operations))}"
                )
            body = arguments if isinstance(arguments, bytes) else _written(arguments)
            self._check(session, found, len(body) + len(attachment))
            most = self._longest(found.lane)
            allowed = most if seconds is None else min(seconds, most)
            async with session.change() if found.edits else nullcontext():
                moved = session.move if found.lane.takes_robot else None
                assignment = Assignment(
                    operation,
                    session.scene,
                    session.positions,
                    body,
                    allowed,
                    listener,
                    moved,
                    driven=session.run is not None,
                    attachment=attachment,
                    stamps=session.stamps,
                )
                job = self.pools[found.lane].submit(session.id, assignment)
                if cancellation is not None:
                    cancellation.of(job)
                answered = await self._answered(session, found, job)
                if found.lane.takes_robot and job.wanted is not None and job.wanted.why is Why.CLOSING:
                    raise job.wanted
            done.waited, done.cpu = job.begun - job.created, answered.cpu
            return Reply(answered.body, answered.cpu)

    def _check(self, session: ServiceSession, operation: Operation, size: int) -> None:
        self._check_open()
        if size > self.limits.body:
            raise RequestRefused(Why.TOO_LARGE, f"a request has {self.limits.body} bytes at most, not {size}")
        if operation.lane.takes_robot and session.run is not None:
            raise RequestRefused(
                Why.BUSY, "the robot of this session is being driven, or its 3-D page is open: stop it first"
            )
        if operation.lane is Lane.VIEWING and self._views >= self.limits.views:
            reason = f"{self._views} 3-D pages are open, as many as there may be: close one"
            raise RequestRefused(Why.FULL, reason, retry_after=1.0)
        if operation.edits and session.editors >= self.limits.waiting_per_session:
            raise RequestRefused(
                Why.FULL, f"{session.editors} changes of this session wait already", retry_after=1.0
            )

    def _longest(self, lane: Lane) -> float:
        limits = self.limits
        return {Lane.DRIVING: limits.run_seconds, Lane.VIEWING: limits.view_seconds}.get(lane, limits.seconds)

    @property
    def _views(self) -> int:
        lanes = [self.operations[job.assignment.operation].lane for job in self._driving.values()]
        return lanes.count(Lane.VIEWING)

    def _check_open(self) -> None:
        if self._closing:
            raise RequestRefused(Why.CLOSING, "the server is closing")

    async def _answered(self, session: ServiceSession, operation: Operation, job: Job) -> Answered:
        try:
            if not operation.lane.takes_robot:
                return await self._held(session, operation, job)
            # Also without anybody who waits, the robot is driven until it stands, and then stands there.
            driving = asyncio.ensure_future(self._held(session, operation, job))
            session.run = job
            self._driving[driving] = job
            driving.add_done_callback(lambda _: session.stand())
            driving.add_done_callback(self._stands)
            await asyncio.wait((driving,))
            return driving.result()
        except asyncio.CancelledError:
            job.cancel()
            raise

    def _stands(self, driving: asyncio.Task[Answered]) -> None:
        del self._driving[driving]
        if not driving.cancelled():
            driving.exception()  # nobody may wait

    async def _held(self, session: ServiceSession, operation: Operation, job: Job) -> Answered:
        await asyncio.wait((job.done,))  # a task that is cancelled would cancel the future
        answered = job.done.result()
        scene = None if answered.scene is None else PackedScene.of(session.robot, answered.scene)
        if scene is not None and len(scene.data) > self.limits.session_bytes:
            most = self.limits.session_bytes
            raise RequestRefused(
                Why.TOO_LARGE, f"the scene would have {len(scene.data)} bytes, of {most} at most"
            )
        positions = answered.positions
        if operation.edits and (session.run is not None or positions == list(job.assignment.positions)):
            positions = None  # a robot that is driven has gone on meanwhile: it says itself where it is
        driven = operation.lane.takes_robot
        changed = scene if operation.edits else None
        await self._settled(session, changed, positions, answered.stamps, driven=driven)
        return answered

    async def _settled(
        self,
        session: ServiceSession,
        scene: PackedScene | None,
        positions: list[float] | None,
        stamps: dict[str, float],
        *,
        driven: bool,
    ) -> None:
        async def settle() -> None:
            if self._keeper is not None and (scene, positions) != (None, None) and session in self.sessions:
                try:
                    await self._keeper.keep(session, scene, positions)
                except RequestRefused:
                    if not driven:
                        raise
            session.replace(scene, positions, stamps)

        settling = asyncio.ensure_future(settle())
        try:
            await asyncio.shield(settling)
        except asyncio.CancelledError:
            await asyncio.wait((settling,))
            raise

    @contextmanager
    def _asked(self) -> Generator[None]:
        task = cast("asyncio.Task[Any]", asyncio.current_task())
        self._asking.add(task)
        try:
            yield
        finally:
            self._asking.discard(task)


def _written(arguments: Mapping[str, Any]) -> bytes:
    try:
        return _JSON.encode(arguments)
    except (TypeError, ValueError, OverflowError, RecursionError) as error:
        raise RequestRefused(Why.MALFORMED, f"the arguments are not plain data for JSON: {error}") from error


Face: TypeAlias = Callable[[Service, asyncio.Event], Awaitable[None]]
"""Serves a started service until an event is set: one protocol on one or several ports."""
SIGNALS = (signal.SIGINT, signal.SIGTERM)


async def run_faces(
    robots: Mapping[str, Robot],
    faces: Sequence[Face],
    *,
    limits: Limits,
    modules: tuple[str, ...] = (OPERATIONS,),
    observer: Callable[[Done], None] | None = None,
    warehouse: Warehouse | None = None,
) -> None:
    """Start a service and its faces, and end them on a signal, or if a face fails.

    The service ends first: meanwhile its faces refuse new requests, and answer running ones.

    Args:
        modules: Modules with the operations that the faces need.
    """
    told, stop, loop = asyncio.Event(), asyncio.Event(), asyncio.get_running_loop()
    for each in SIGNALS:
        loop.add_signal_handler(each, told.set)
    try:
        served = Service(robots, limits=limits, modules=modules, observer=observer, warehouse=warehouse)
        async with served as service:
            serving = [asyncio.ensure_future(face(service, stop)) for face in faces]
            waits = (*serving, asyncio.ensure_future(told.wait()))
            await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
            await service.close(drain=limits.grace)
            stop.set()
            await asyncio.gather(*serving)
    finally:
        for each in SIGNALS:
            loop.remove_signal_handler(each)


_LOG = logging.getLogger("trajopt.server")
PLAIN = frozenset(vars(logging.makeLogRecord({}))) | {"message", "asctime", "taskName", "color_message"}
"""Standard attributes of a log record; the others are data."""


class JsonLines(logging.Formatter):
    """Writes a record as a line of JSON."""

    def format(self, record: logging.LogRecord) -> str:
        stamp = time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(record.created))
        said: dict[str, object] = {
            "time": f"{stamp}.{int(record.msecs):03d}Z",
            "level": record.levelname.lower(),
            "event": record.getMessage(),
        }
        said.update((key, value) for key, value in vars(record).items() if key not in PLAIN)
        if record.exc_info:
            said["trace"] = self.formatException(record.exc_info)
        return json.dumps(said, default=str)


def write_log() -> None:
    """Write the log of the server and its libraries to standard error."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(JsonLines())
    for name in ("trajopt.server", "uvicorn", "websockets"):
        logger = logging.getLogger(name)
        logger.handlers, logger.propagate = [handler], False
        logger.setLevel(logging.INFO)


def log_request(done: Done) -> None:
    """Log a request that is over."""
    if not _LOG.isEnabledFor(logging.INFO):
        return
    said = {
        "operation": done.operation,
        "session": done.session[:SHOWN],
        "outcome": "answered" if done.why is None else done.why.value,
        "reason": done.reason,
        "waited": round(done.waited, 4),
        "seconds": round(done.seconds, 4),
        "cpu": round(done.cpu, 4),
    }
    # Made by hand: to look for the line that logs costs more than the rest, and it is always this one.
    record = _LOG.makeRecord(_LOG.name, logging.INFO, __file__, 0, "request", (), None, None, said)
    _LOG.handle(record)
