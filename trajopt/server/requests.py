"""A request from the caller's view: answer, outcome and cancellation."""

import asyncio
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import msgspec

from trajopt.server.job import Job
from trajopt.server.refusals import Refusal, Why
from trajopt.values.arrays import Value


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
    """A finished request.

    Attributes:
        operation: Name of the operation.
        session: Id of the session.
        why: Kind of refusal; None with an answer.
        reason: The reason in a sentence.
        waited: Time until a worker began, with an answer [s].
        seconds: Total time [s].
        cpu: CPU time of the worker, with an answer [s].
    """

    operation: str
    session: str
    why: Why | None = None
    reason: str = ""
    waited: float = 0.0
    seconds: float = 0.0
    cpu: float = 0.0


@contextmanager
def counted(session: str, operation: str, observer: Callable[[Done], None] | None) -> Generator[Done]:
    """Record the outcome of a request, and notify the observer.

    Args:
        session: Id of its session.
        operation: Name of the operation.
        observer: The observer, or None.
    """
    begin, done = time.monotonic(), Done(operation, session)
    try:
        yield done
    except Refusal as refusal:
        done.why, done.reason = refusal.why, refusal.reason
        raise
    except asyncio.CancelledError:
        done.why, done.reason = Why.CANCELLED, "nobody waits for it any more"
        raise
    except Exception as error:
        done.why, done.reason = Why.FAILED, f"{type(error).__name__}: {error}"
        raise
    finally:
        done.seconds = time.monotonic() - begin
        if observer is not None:
            observer(done)


class Cancellation:
    """Cancels a request from elsewhere: pass it to `ask`, and call it."""

    def __init__(self) -> None:
        """Belong to no request yet."""
        self._job: Job | None = None
        self._called = False

    def __call__(self) -> None:
        """Cancel the request: a plan returns its best motion so far; a waiting request is refused."""
        self._called = True
        if self._job is not None:
            self._job.cancel()

    def of(self, job: Job) -> None:
        """Belong to a request."""
        self._job = job
        if self._called:
            job.cancel()
