"""Refusals of requests, of a few kinds, with a reason for the client."""

from enum import Enum

from trajopt.values.errors import TrajoptError


class Why(Enum):
    """Kinds of refusals; each value is its name in messages."""

    MALFORMED = "malformed"
    UNKNOWN = "unknown"
    TOO_LARGE = "too large"
    BUSY = "busy"
    FULL = "full"
    OUT_OF_TIME = "out of time"
    OUT_OF_MEMORY = "out of memory"
    WORKER_LOST = "worker lost"
    CANCELLED = "cancelled"
    CLOSING = "closing"
    FAILED = "failed"


class Refusal(TrajoptError):
    """A refused request.

    Attributes:
        why: The kind.
        reason: The reason, in a sentence.
        retry_after: Delay before a sensible retry [s]; None without one.
    """

    def __init__(self, why: Why, reason: str, *, retry_after: float | None = None) -> None:
        """Keep kind and reason."""
        self.why, self.reason, self.retry_after = why, reason, retry_after
        super().__init__(f"{why.value}: {reason}")

    def as_dict(self) -> dict[str, object]:
        """Return plain data that JSON can hold."""
        return {"error": {"kind": self.why.value, "reason": self.reason}}
