"""What is at hand to try the arguments of the server and its client with."""

from collections.abc import Mapping
from typing import Any

import trajopt as to
from trajopt.server import Service, Watch
from trajopt.server.client import AsyncClient, Client, Session


def served(robot: to.Robot) -> Mapping[str, Any]:
    """Return a service that is not started, clients that are not connected, and what belongs to them."""
    client, service = Client("http://127.0.0.1:9"), Service({"planar2": robot})
    return {
        "Client": client,
        "AsyncClient": AsyncClient("http://127.0.0.1:9"),
        "SessionCalls": Session(client, "0", "planar2"),
        "Service": service,
        "Watch": Watch(1.0),
    }
