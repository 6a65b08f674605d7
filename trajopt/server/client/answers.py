"""What comes over the wire: answers, events, refusals."""

import json
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias, cast

import httpx

from trajopt.files.moveit.joint_trajectory import read_points
from trajopt.server.client.errors import ServerError
from trajopt.values.documents.document import Node
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory

Document: TypeAlias = dict[str, Any]
"""What a server says, as plain data."""
Listener: TypeAlias = Callable[[Document], None]
"""Told how far a request is."""
FULL = 429
"""The server has more to do than it takes on: it says when to come again."""
AGAIN = "x-retry-after"
SHORTEST = 0.01
"""A client that is told to come again at once still waits so long [s]."""


@checked
def trajectory_of(answer: Mapping[str, Any]) -> Trajectory | None:
    """Return the motion of an answer; None where there is none.

    Args:
        answer: Of `plan` or `follow`.
    """
    if not answer.get("points"):
        return None
    return read_points(Node({key: answer[key] for key in ("joint_names", "points")}, "answer"))


def document_of(response: httpx.Response) -> Any:
    """Return what a server answered.

    Raises:
        ServerError: If it refused.
    """
    try:
        document = response.json()
    except ValueError:
        document = None
    if response.is_success and document is not None:
        return document
    raise error_of(response.status_code, document)


def error_of(status: int, document: object) -> ServerError:
    """Return the error that a server's document states."""
    error: object = cast(Document, document).get("error") if isinstance(document, dict) else None
    if not isinstance(error, dict):
        return ServerError(status, "failed", f"the server answered with status {status}")
    stated = cast(Document, error)
    return ServerError(status, str(stated.get("kind")), str(stated.get("reason")))


def again_after(response: httpx.Response) -> float | None:
    """Return when a server that is full says to come again [s]; None where it is not full."""
    if response.status_code != FULL:
        return None
    return max(float(response.headers.get(AGAIN, response.headers.get("retry-after", "1"))), SHORTEST)


def refusal_of(document: Document) -> ServerError:
    """Return the error that a refusal among events states: its number is in it, since HTTP's has gone by."""
    error = error_of(int(document.get("status", 200)), document)
    after = document.get("retry_after")
    error.retry_after = max(float(after), SHORTEST) if after is not None and error.status == FULL else None
    return error


class Events:
    """Server-sent events, line by line."""

    def __init__(self, listener: Listener) -> None:
        """Pass feedback on to a listener."""
        self._listener, self._name = listener, ""

    def take(self, line: str) -> Document | None:
        """Take a line; return the answer, once it is there.

        Raises:
            ServerError: If there will be none.
        """
        if line.startswith("event: "):
            self._name = line.removeprefix("event: ")
        if not line.startswith("data: "):
            return None
        document: Document = json.loads(line.removeprefix("data: "))
        if self._name == "answer":
            return document
        if self._name == "refusal":
            raise refusal_of(document)
        self._listener(document)
        return None
