"""Requests in progress: waiting, in a worker, answered, refused or cancelled."""

import asyncio
import time
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import msgspec

from trajopt.server.limits import RequestRefused, Why
from trajopt.server.messages import Answered, Cancel, Changed, Feedback, Request
from trajopt.server.operation import PackedScene
from trajopt.server.worker_process import WorkerProcess
from trajopt.values.arrays import Value

Listener: TypeAlias = Callable[[msgspec.Raw], None]
"""Receives the progress of a request as JSON."""


@dataclass(frozen=True)
class Assignment(Value):
    """Work for a worker.

    Attributes:
        moved: Receives the robot's positions while it is driven [rad | m].
    """

    operation: str
    scene: PackedScene
    positions: Sequence[float]
    body: bytes
    seconds: float
    listener: Listener | None = None
    moved: Callable[[list[float]], None] | None = None
    driven: bool = False
    attachment: bytes = b""
    stamps: Mapping[str, float] = field(default_factory=dict[str, float])


class Job:
    """A request in progress, begun by a worker at a time of the loop's clock [s]."""

    def __init__(self, number: int, owner: str, assignment: Assignment, grace: float) -> None:
        loop = asyncio.get_running_loop()
        self.number, self.owner, self.assignment = number, owner, assignment
        self.done: asyncio.Future[Answered] = loop.create_future()
        self.done.add_done_callback(lambda done: done.cancelled() or done.exception())  # nobody may wait
        self.created, self.begun = loop.time(), 0.0
        self._grace, self._loop = grace, loop
        self._until = self.created + assignment.seconds
        self._worker: WorkerProcess | None = None
        self.wanted: RequestRefused | None = None
        self._timers = [loop.call_at(self._until, self._out_of_time)]

    @property
    def over(self) -> bool:
        return self.done.done()

    def begin(self, worker: WorkerProcess) -> None:
        """Pass the request to a worker."""
        self._worker, self.begun = worker, self._loop.time()
        assignment = self.assignment
        request = Request(
            self.number,
            assignment.operation,
            assignment.scene.robot,
            assignment.scene.data,
            assignment.scene.key,
            dict(assignment.stamps),
            list(assignment.positions),
            assignment.body,
            assignment.attachment,
            max(self._until - self.begun, 0.0),
            assignment.listener is not None or assignment.moved is not None,
            assignment.driven,
        )
        worker.send(request)

    def cancel(self, refusal: RequestRefused | None = None) -> None:
        self._end(refusal or RequestRefused(Why.CANCELLED, "it was cancelled"))

    def change(self, scene: PackedScene) -> None:
        if self._worker is not None and not self.over:
            self._worker.send(Changed(self.number, scene.robot, scene.data, scene.key))

    def tell(self, feedback: Feedback) -> None:
        if feedback.positions is not None and self.assignment.moved is not None:
            self.assignment.moved(feedback.positions)
        if self.assignment.listener is not None and not self.over:
            try:
                self.assignment.listener(msgspec.Raw(feedback.body))
            except Exception as error:
                self.cancel()
                self.done.set_exception(error)

    def answer(self, answered: Answered) -> None:
        self._finish()
        if not self.over:
            self.done.set_result(answered)

    def refuse(self, refusal: RequestRefused) -> None:
        self._finish()
        if not self.over:
            self.done.set_exception(self.wanted or refusal)

    def _out_of_time(self) -> None:
        waited = "" if self._worker is not None else ", all of which it waited for a process"
        self._end(
            RequestRefused(Why.OUT_OF_TIME, f"it took longer than {self.assignment.seconds:g} s{waited}")
        )

    def _end(self, refusal: RequestRefused) -> None:
        if self.over or self.wanted is not None:
            return
        self.wanted = refusal
        if self._worker is None:
            self.refuse(refusal)
            return
        self._worker.send(Cancel(self.number))
        self._timers.append(self._loop.call_later(self._grace, self._worker.kill))

    def _finish(self) -> None:
        self._worker = None
        for timer in self._timers:
            timer.cancel()


@dataclass(frozen=True)
class Reply(Value):
    """The answer to a request, as JSON."""

    body: bytes
    cpu: float

    def document(self) -> Any:
        """Return it as plain data."""
        return msgspec.json.decode(self.body)


@dataclass(eq=False)
class Done:
    """A finished request."""

    operation: str
    session: str
    why: Why | None = None
    reason: str = ""
    waited: float = 0.0
    seconds: float = 0.0
    cpu: float = 0.0


@contextmanager
def counted(session: str, operation: str, observer: Callable[[Done], None] | None) -> Generator[Done]:
    """Record the outcome of a request, and notify the observer, if any."""
    begin, done = time.monotonic(), Done(operation, session)
    try:
        yield done
    except RequestRefused as refusal:
        done.why, done.reason = refusal.why, refusal.reason
        raise
    except asyncio.CancelledError:
        done.why, done.reason = Why.CANCELLED, "its client has left"
        raise
    except Exception as error:
        done.why, done.reason = Why.FAILED, f"{type(error).__name__}: {error}"
        raise
    finally:
        done.seconds = time.monotonic() - begin
        if observer is not None:
            observer(done)


class Cancellation:
    """Cancels a request from elsewhere, by a call."""

    def __init__(self) -> None:
        self._job: Job | None = None
        self._called = False

    def __call__(self) -> None:
        self._called = True
        if self._job is not None:
            self._job.cancel()

    def of(self, job: Job) -> None:
        """Belong to a request."""
        self._job = job
        if self._called:
            job.cancel()
