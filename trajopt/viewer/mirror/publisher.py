"""Publisher: publishes the robot of a run and its known surroundings over HTTP.

It answers the requests of a mirror as a session of `trajopt serve` does: `GET /state`, `POST /robot`,
`POST /scene`. It is read-only: it cannot move or stop a robot.
"""

import json
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import numpy as np

from trajopt.driving.recording import Logbook, RecordedMoment, Watched
from trajopt.files.bundle.message import message_of
from trajopt.problem.problem import Problem
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, one_of
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory
from trajopt.viewer.mirror.state import State

AHEAD = 25
"""Number of configurations along the rest of a motion: enough for a smooth line of the hand."""
EVENTS = 12
"""Number of published events, the latest ones."""
PATIENCE = 10.0
"""Time-out of a silent connection [s]."""
LARGEST = 4096
"""Largest body of a request [bytes]; none is needed."""
LOCAL = ("127.0.0.1", "localhost", "[::1]")


class Publisher:
    """Publishes a run: `run(problem, watch=publisher.look)`. A context manager; or call `close`.

    Attributes:
        url: Address for `trajopt view --mirror`.
    """

    @checked
    def __init__(self, problem: Problem, *, port: int = 8090, host: str = "127.0.0.1") -> None:
        """Start to answer.

        Args:
            problem: The problem of the run.
            port: Port; any free one if 0.
            host: Address to answer on; "0.0.0.0" lets other machines connect too.

        Raises:
            ProblemError: If the port cannot be opened on this host.
        """
        self._problem, self._logbook = one_of("problem", problem, Problem), Logbook()
        self._lock, self._revision = threading.Lock(), 0
        self._told: tuple[object, float] = (None, 0.0)
        try:
            self._server = ThreadingHTTPServer((host, port), _handler_of(self, host))
        except (OSError, OverflowError) as error:
            raise ProblemError(f"nothing can be served on {shown(host)}, port {port}: {error}") from error
        self._server.daemon_threads = True
        name = "localhost" if host == "0.0.0.0" else host
        self.url = f"http://{name}:{self._server.server_address[1]}"
        self._thread = threading.Thread(
            target=self._server.serve_forever, name="trajopt publisher", daemon=True
        )
        self._thread.start()

    def __enter__(self) -> "Publisher":
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Stop answering."""
        self.close()

    @checked
    def look(self, watched: Watched) -> None:
        """Read the state of the supervisor, after each cycle.

        Raises:
            ProblemError: If it is another supervisor than before.
        """
        self._logbook.look(watched)

    def close(self) -> None:
        """Stop answering."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def robot(self) -> dict[str, object]:
        """Return the robot as a message."""
        return message_of(self._problem.scene.robot, {})

    def scene(self) -> dict[str, object]:
        """Return the present surroundings as a message, without the robot."""
        return message_of(self._scene(), {"robot": self._problem.scene.robot})

    def state(self) -> State:
        """Return the present state."""
        moment, reduced = self._moment(), self._problem.reduced
        if moment is None:
            return State(revision=0, positions=self._problem.start_positions, driven=False)
        return State(
            revision=self._revised(moment),
            positions=reduced.all_positions(moment.positions),
            driven=moment.stop is not None,
            ahead=None if moment.plan is None else self._ahead(moment.plan),
            events=moment.events[-EVENTS:],
        )

    def _moment(self) -> RecordedMoment | None:
        return self._logbook.moment if self._logbook.samples else None

    def _scene(self) -> Scene:
        moment = self._moment()
        if moment is None:
            return self._problem.scene.still_at(0.0)
        world = moment.sighting.world
        return world.scene.still_at(moment.time - world.stamp)

    def _revised(self, moment: RecordedMoment) -> int:
        """Return the revision of the surroundings, which changes with them."""
        scene = moment.sighting.world.scene
        now = (moment.sighting, moment.time if scene.changing else 0.0)
        with self._lock:
            if now[0] is not self._told[0] or now[1] != self._told[1]:
                self._told, self._revision = now, self._revision + 1
            return self._revision

    def _ahead(self, plan: Trajectory) -> Floats:
        along = plan(np.linspace(0.0, plan.duration, AHEAD))
        return np.array([self._problem.reduced.all_positions(each) for each in along])


def _handler_of(publisher: Publisher, host: str) -> type[BaseHTTPRequestHandler]:
    """Return the handler of requests; on this machine only for its own host names.

    Otherwise a page of another site could use a name that resolves to this machine.
    """

    class Handler(BaseHTTPRequestHandler):
        timeout = PATIENCE

        def do_GET(self) -> None:
            self._answer({"/state": lambda: publisher.state().as_dict()})

        def do_POST(self) -> None:
            self._answer({"/robot": publisher.robot, "/scene": publisher.scene})

        def log_message(self, format: str, *args: Any) -> None:
            """Do not log to standard error."""

        def _answer(self, known: dict[str, Any]) -> None:
            # What comes with a request says nothing here; unread, it would have the connection reset.
            length = self.headers.get("content-length", "0")
            self.rfile.read(min(int(length), LARGEST) if length.isdigit() else 0)
            called = self.headers.get("host", "").rpartition(":")[0].lower()
            if host in LOCAL and called not in LOCAL:
                self._send(421, {"error": {"kind": "malformed", "reason": "not known by that name"}})
            elif self.path not in known:
                self._send(404, {"error": {"kind": "unknown", "reason": "there is nothing at this address"}})
            else:
                self._send(200, known[self.path]())

        def _send(self, status: int, document: dict[str, Any]) -> None:
            body = json.dumps(document).encode()
            self.send_response(status)
            self.send_header("content-type", "application/json")
            self.send_header("content-length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

    return Handler
