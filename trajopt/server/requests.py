"""A request as who asks sees it: the answer, how it ended, and how to end it from elsewhere."""

from dataclasses import dataclass
from typing import Any

import msgspec

from trajopt.arrays import Value
from trajopt.server.job import Job
from trajopt.server.refusals import Why


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
