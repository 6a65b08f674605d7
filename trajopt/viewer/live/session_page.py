"""The live page of a session of `trajopt serve`: an operation of the server, which lasts while it is open."""

from collections.abc import Mapping
from urllib.parse import urlsplit

import numpy as np

from trajopt.server.operation import Answer, Lane, Operation, SessionState, Watch
from trajopt.values.documents.document import Node
from trajopt.values.errors import ProblemError
from trajopt.viewer.live.page import LiveView, live_view

PERIOD = 0.1
"""Time from one look at the session to the next [s]."""


def page(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Serve the live page of a session until the request is cancelled.

    The first feedback has `port` and `path` of the page, and its `group`. Edits of the session are shown on
    the page, and the session's robot follows the page's.

    Raises:
        MissingExtra: If viser is not installed.
        ProblemError: If no port is free, or something in the scene moves by itself.
    """
    first, last = int(arguments["first_port"].number()), int(arguments["last_port"].number())
    live = live_view(
        state.scene,
        group=arguments["group"].text(""),
        start=state.positions,
        port=first,
        host=arguments["host"].text(),
    )
    try:
        address = urlsplit(live.url)
        if address.port is None or not first <= address.port <= last:
            raise ProblemError(
                f"no port from {first} to {last} is free for the 3-D page: serve on another --port"
            )
        watch.tell({"port": address.port, "path": address.path, "group": live.group})
        _follow(live, watch)
    finally:
        live.close()
    return Answer({})


def _follow(live: LiveView, watch: Watch) -> None:
    told = live.robot_positions
    while not watch.cancel.wait(PERIOD):
        scene, now = watch.changed(), live.robot_positions
        if scene is not None:
            live.see(scene)
        if not np.array_equal(now, told):
            watch.tell({"positions": now.tolist()}, now.tolist())
            told = now


OPERATIONS: Mapping[str, Operation] = {"viewer/page": Operation(page, Lane.VIEWING)}
"""The operation behind the 3-D view on the page of `trajopt serve`."""
