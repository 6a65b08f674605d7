"""Service: robots, sessions and workers, behind every face of the server; it knows no protocol."""

import asyncio
import pickle
import time
from collections.abc import AsyncGenerator, Callable, Generator, Mapping
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass
from types import TracebackType
from typing import Any, cast

import msgspec

from trajopt.arrays import Value
from trajopt.errors import ProblemError, RobotNotFound, listed, shown
from trajopt.errors.arguments import checked
from trajopt.model.initial_positions import initial_positions
from trajopt.model.robot import Robot
from trajopt.model.scene import Scene
from trajopt.server.job import Assignment, Job, Listener
from trajopt.server.limits import Limits
from trajopt.server.messages import Answered, Hello
from trajopt.server.operation import Lane, Operation, operations_of
from trajopt.server.pool import Pool
from trajopt.server.refusals import Refusal, Why
from trajopt.server.session import Session, Sessions
from trajopt.server.state import PackedScene, SessionState, packed
from trajopt.server.worker_process import WorkerLost

OPERATIONS = "trajopt.server.operations"
"""The module of the operations that every server has."""
DEFAULT = Limits()
_JSON = msgspec.json.Encoder()


@dataclass(frozen=True)
class Reply(Value):
    """The answer to a request.

    Attributes:
        body: JSON.
        cpu: Processor time that it took [s].
    """

    body: bytes
    cpu: float

    def document(self) -> Any:
        """Return it as plain data."""
        return msgspec.json.decode(self.body)


@dataclass(eq=False)
class Done:
    """A request that is over.

    Attributes:
        operation: What was asked.
        session: Id of the session.
        why: Why there is no answer; None where there is one.
        reason: The same in a sentence.
        waited: Time until a worker began with it, where there is an answer [s].
        seconds: Time from when it was asked [s].
        cpu: Processor time of the worker, where there is an answer [s].
    """

    operation: str
    session: str
    why: Why | None = None
    reason: str = ""
    waited: float = 0.0
    seconds: float = 0.0
    cpu: float = 0.0


class Cancellation:
    """Ends a request from elsewhere: give it to `ask`, and call it."""

    def __init__(self) -> None:
        """Belong to no request yet."""
        self._job: Job | None = None
        self._called = False

    def __call__(self) -> None:
        """End the request: a plan returns what it has so far; what still waits is refused."""
        self._called = True
        if self._job is not None:
            self._job.cancel()

    def of(self, job: Job) -> None:
        """Belong to a request."""
        self._job = job
        if self._called:
            job.cancel()


class Service:
    """Robots, sessions and workers; `async with` starts and ends them.

    Attributes:
        robots: The robots by name.
        limits: What clients may take.
        sessions: The sessions.
        operations: What can be asked, by name.
        pools: The workers of each lane.
    """

    @checked
    def __init__(
        self,
        robots: Mapping[str, Robot],
        *,
        limits: Limits = DEFAULT,
        modules: tuple[str, ...] = (OPERATIONS,),
        observer: Callable[[Done], None] | None = None,
    ) -> None:
        """Take what is served.

        Args:
            robots: The robots by name, the one that is meant where none is named first.
            limits: What clients may take.
            modules: Modules whose `OPERATIONS` can be asked for.
            observer: Called with each request that is over.

        Raises:
            ProblemError: If there is no robot.
        """
        if not robots:
            raise ProblemError("a service needs at least one robot")
        self.robots, self.limits, self.sessions = dict(robots), limits, Sessions(limits)
        self.operations: Mapping[str, Operation] = operations_of(modules)
        pickled = {name: pickle.dumps(robot) for name, robot in robots.items()}
        hello = Hello(pickled, modules, limits.memory, limits.triangles, limits.points)
        self.pools = {
            Lane.PLANNING: Pool("planning", hello, limits.workers, limits),
            Lane.QUICK: Pool("quick", hello, 1, limits),
            Lane.DRIVING: Pool("driving", hello, limits.runs, limits, eager=False),
        }
        self._observer, self._closing = observer, False
        self._asking: set[asyncio.Task[Any]] = set()
        self._empty: dict[str, tuple[PackedScene, list[float]]] = {}

    async def __aenter__(self) -> "Service":
        """Start the workers; returns when they are ready."""
        try:
            await asyncio.gather(*(pool.start() for pool in self.pools.values()))
        except WorkerLost as error:
            await self.close(drain=0.0)
            raise Refusal(Why.WORKER_LOST, f"a worker did not come up: {error}") from error
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """End the workers, those at work after a moment."""
        await self.close(drain=self.limits.grace)

    @checked
    async def close(self, *, drain: float) -> None:
        """Take no more requests, and end the workers.

        Args:
            drain: How long requests that a worker has begun with may still take [s].
        """
        self._closing = True
        if drain and self._asking:
            await asyncio.wait(self._asking, timeout=drain)
        await asyncio.gather(*(pool.close() for pool in self.pools.values()))

    @property
    def closing(self) -> bool:
        """Whether no more requests are taken."""
        return self._closing

    @checked
    def create(self, robot: str = "", *, kept: bool = False) -> Session:
        """Begin a session: a robot in an empty world, each group in its first named state.

        Args:
            robot: Its name; the first one where it is empty.
            kept: Whether the session stays although nobody uses it.

        Raises:
            RobotNotFound: If there is no such robot.
            Refusal: If there are too many sessions.
        """
        name = robot or next(iter(self.robots))
        if name not in self.robots:
            raise RobotNotFound("robot", name, self.robots)
        if name not in self._empty:
            loaded = self.robots[name]
            state = SessionState(name, Scene(loaded), initial_positions(loaded))
            self._empty[name] = packed(state, self.robots), state.positions.tolist()
        scene, positions = self._empty[name]
        return self.sessions.add(scene, positions, kept=kept)

    @checked
    def fork(self, session: Session) -> Session:
        """Begin a session with what another one holds now; from then on they are apart.

        Raises:
            Refusal: If there are too many sessions.
        """
        return self.sessions.add(session.scene, session.positions)

    @checked
    async def ask(
        self,
        session: Session,
        operation: str,
        arguments: bytes | Mapping[str, Any] = b"{}",
        *,
        seconds: float | None = None,
        listener: Listener | None = None,
        cancellation: Cancellation | None = None,
    ) -> Reply:
        """Ask for an operation, and wait for the answer. Whoever is cancelled here cancels the request.

        Args:
            session: Whose scene and robot it is about; what it changes, the session holds afterwards.
            operation: Its name.
            arguments: JSON, or plain data.
            seconds: Time that it may take, waiting included [s]; no more than the limits allow.
            listener: Told, as JSON, how far it is.
            cancellation: Ends it from elsewhere.

        Raises:
            Refusal: If it is not answered.
        """
        with self._counted(session, operation) as done:
            found = self.operations.get(operation)
            if found is None:
                raise Refusal(
                    Why.UNKNOWN, f"no operation {shown(operation)}; known: {listed(sorted(self.operations))}"
                )
            body = arguments if isinstance(arguments, bytes) else _JSON.encode(arguments)
            self._check(session, found, body)
            most = self.limits.run_seconds if found.lane is Lane.DRIVING else self.limits.seconds
            allowed = most if seconds is None else min(seconds, most)
            async with self._turn(session, found):
                moved = session.move if found.lane is Lane.DRIVING else None
                assignment = Assignment(
                    operation,
                    session.scene,
                    session.positions,
                    body,
                    allowed,
                    listener,
                    moved,
                    driven=session.run is not None,
                )
                job = self.pools[found.lane].submit(session.id, assignment)
                if cancellation is not None:
                    cancellation.of(job)
                answered = await self._answered(session, found, job)
            done.waited, done.cpu = job.begun - job.created, answered.cpu
            return Reply(answered.body, answered.cpu)

    def _check(self, session: Session, operation: Operation, body: bytes) -> None:
        """Refuse what need not wait for a worker to be refused."""
        if self._closing:
            raise Refusal(Why.CLOSING, "the server is closing")
        if len(body) > self.limits.body:
            raise Refusal(Why.TOO_LARGE, f"a request has {self.limits.body} bytes at most, not {len(body)}")
        if operation.lane is Lane.DRIVING and session.run is not None:
            raise Refusal(Why.BUSY, "the robot of this session is being driven: stop it first")
        if operation.edits and session.editors >= self.limits.waiting_per_session:
            raise Refusal(
                Why.FULL, f"{session.editors} changes of this session wait already", retry_after=1.0
            )

    @asynccontextmanager
    async def _turn(self, session: Session, operation: Operation) -> AsyncGenerator[None]:
        """Wait until it is the turn of a request that changes its session; others need not wait."""
        if not operation.edits:
            yield
            return
        session.editors += 1
        try:
            async with session.editing:
                yield
        finally:
            session.editors -= 1

    async def _answered(self, session: Session, operation: Operation, job: Job) -> Answered:
        """Wait for the answer, and have the session hold what it changed."""
        if operation.lane is Lane.DRIVING:
            session.run = job
        try:
            await asyncio.wait((job.done,))  # a task that is cancelled would cancel the future
        except asyncio.CancelledError:
            job.cancel()
            raise
        finally:
            if operation.lane is Lane.DRIVING:
                session.run = None
        answered = job.done.result()
        scene = None if answered.scene is None else PackedScene.of(session.robot, answered.scene)
        if scene is not None and len(scene.data) > self.limits.session_bytes:
            most = self.limits.session_bytes
            raise Refusal(Why.TOO_LARGE, f"the scene would have {len(scene.data)} bytes, of {most} at most")
        positions = answered.positions
        if operation.edits and (session.run is not None or positions == list(job.assignment.positions)):
            positions = None  # a robot that is driven has gone on meanwhile: it says itself where it is
        session.replace(scene if operation.edits else None, positions)
        return answered

    @contextmanager
    def _counted(self, session: Session, operation: str) -> Generator[Done]:
        """Keep count of a request, and tell the observer when it is over."""
        task = asyncio.current_task()
        begin, done = time.monotonic(), Done(operation, session.id)
        try:
            if task is not None:
                self._asking.add(task)
            yield done
        except Refusal as refusal:
            done.why, done.reason = refusal.why, refusal.reason
            raise
        except asyncio.CancelledError:
            done.why, done.reason = Why.CANCELLED, "nobody waits for it any more"
            raise
        finally:
            self._asking.discard(cast("asyncio.Task[Any]", task))
            done.seconds = time.monotonic() - begin
            if self._observer is not None:
                self._observer(done)
