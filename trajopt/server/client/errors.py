"""What a server says no with."""

from trajopt.values.errors import TrajoptError


class ServerError(TrajoptError):
    """A server did not answer what was asked.

    Attributes:
        status: HTTP's number of it; 0 where the server could not be reached.
        kind: The server's word for it, such as "malformed" or "full".
        reason: What was wrong, in a sentence.
        retry_after: When a server that is full says to come again [s]; None where it is not full, or says so
            otherwise.
    """

    retry_after: float | None = None

    def __init__(self, status: int, kind: str, reason: str) -> None:
        """Keep all three."""
        self.status, self.kind, self.reason = status, kind, reason
        super().__init__(f"{kind}: {reason}")
