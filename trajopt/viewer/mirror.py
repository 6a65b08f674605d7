"""Mirror: a page of a robot driven elsewhere."""

import json
import threading
import time
from dataclasses import dataclass
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from trajopt.driving import Event, EventKind
from trajopt.driving.commit_loop import CommitLoop
from trajopt.driving.recording import Logbook, RecordedMoment
from trajopt.files.bundle.containers import message_of, value_of_message
from trajopt.geometry import JointPlacements
from trajopt.problem.problem import Problem
from trajopt.robot.robot import Robot
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model, tool_frame, whole_robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Value, floats, one_of
from trajopt.values.documents.document import Node
from trajopt.values.errors import MissingExtra, ProblemError, TrajoptError, shown
from trajopt.values.errors.arguments import checked, checked_class
from trajopt.values.trajectory import Trajectory
from trajopt.viewer import palette
from trajopt.viewer.clearance import Nearest
from trajopt.viewer.drawing import Ghost, Trail
from trajopt.viewer.live.handles import EditedScene
from trajopt.viewer.live.workbench import chosen_group
from trajopt.viewer.palette import NARROW, SAFE, TOUCHING
from trajopt.viewer.readout import block_html, events_html
from trajopt.viewer.scene_view import look_from_the_best_side
from trajopt.viewer.server import Served, open_server

if TYPE_CHECKING:
    from trajopt.viewer.guarded_server import GuardedServer


@dataclass(frozen=True, eq=False, kw_only=True)
class RemoteState(Value):
    """State of a remote robot.

    Attributes:
        ahead: Positions of all joints along the rest of its motion, shape (k, number of joints); None
            if unknown.
    """

    revision: int
    positions: Floats
    driven: bool
    ahead: Floats | None = None
    events: tuple[Event, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        return {
            "revision": self.revision,
            "positions": self.positions.tolist(),
            "driven": self.driven,
            "ahead": None if self.ahead is None else self.ahead.tolist(),
            "events": [each.as_dict() for each in self.events],
        }


def state_of(node: Node, joints: int) -> RemoteState:
    """Return the state in a document."""
    ahead = node["ahead"]
    return RemoteState(
        revision=int(node["revision"].number()),
        positions=floats("positions", cast("Any", node["positions"].value), (joints,)),
        driven=node["driven"].flag(),
        ahead=None if ahead.missing else floats("ahead", cast("Any", ahead.value), (None, joints)),
        events=tuple(_event(each) for each in node["events"].elements()),
    )


def _event(node: Node) -> Event:
    name = node["kind"].text()
    if name not in {each.value for each in EventKind}:
        raise node["kind"].error(f"{name!r} is not a kind of event")
    return Event(node["time"].number(), EventKind(name), node["words"].text(""))


PATIENCE = 5.0
"""Time-out of a request [s]."""


class MirrorClient:
    """A mirrored address."""

    def __init__(self, url: str, *, token: str = "") -> None:
        """Request the robot; `url` as for `mirror_view`."""
        try:
            from trajopt.server.client import Call, Client
        except ImportError as error:
            raise MissingExtra("httpx", "server") from error
        self.url = url.rstrip("/")
        self._client, self._call = Client(self.url, token=token, patience=0.0, timeout=PATIENCE), Call
        try:
            self.robot = value_of_message(self._asked("POST", "robot"), {}, Robot)
        except BaseException:
            self._client.close()
            raise

    def state(self) -> RemoteState:
        return state_of(self._asked("GET", "state"), len(self.robot.joint_names))

    def scene(self) -> Scene:
        known = {"robot": self.robot}
        return value_of_message(self._asked("POST", "scene"), known, Scene).still_at(0.0)

    def close(self) -> None:
        self._client.close()

    def _asked(self, method: str, path: str) -> Node:
        body: dict[str, object] | None = {} if method == "POST" else None
        answer: object = self._client.send(self._call(method, f"/{path}", body))
        return Node(answer, f"{self.url}/{path}")


PERIOD = 1 / 15
"""Polling period [s]: a server updates its robot's state ten times a second."""
AGAIN = 1.0
"""Delay before another request without an answer [s]."""
OLD = 1.0
"""Age from which a state is marked as old [s]."""
EVENTS = 8
"""Number of listed events, the latest ones."""


@checked
def mirror_view(url: str, *, token: str = "", port: int = 8080, host: str = "127.0.0.1") -> "MirrorView":
    """Serve a page that shows a remote robot and its known surroundings, as `view` does.

    Args:
        url: Of a session of `trajopt serve` ("http://127.0.0.1:8080/sessions/ID"), or of a published run
            (`trajopt run --publish`, or a `RunPublisher`).

    Raises:
        ServerError: If the address does not answer, or refuses.
        FileFormatError: If the answer cannot be mirrored.
    """
    source = MirrorClient(url, token=token)
    try:
        state, scene = source.state(), source.scene()
        return MirrorView(open_server(host, port), source, state, scene)
    except BaseException:
        source.close()
        raise


class MirrorView(Served):
    """A page that shows a remote robot; `mirror_view` opens one."""

    def __init__(
        self, server: "GuardedServer", source: MirrorClient, state: RemoteState, scene: Scene
    ) -> None:
        super().__init__(server)
        self._source, self.state, self.scene = source, state, scene
        self._joints = tuple(name for name in scene.robot.joint_names if name not in scene.robot.mimics)
        self._heard, self._lost = time.monotonic(), ""
        columns, reduced = scene.robot.index(self._joints), self._whole(scene)
        self._hand = tool_frame(reduce_model(scene, chosen_group(scene.robot), state.positions))
        look_from_the_best_side(server, reduced, None, back=1.35, aside=0.16)
        self._scene = EditedScene(server, reduced, state.positions[columns])
        self._ghost = Ghost(server, reduced, "ahead", palette.TOOL_PATH)
        self._trail = Trail(server, "/ahead_path", palette.TOOL_PATH, 3.0)
        self._text = server.gui.add_html("")
        self._events = server.gui.add_html("")
        self._show()
        self._follower = threading.Thread(target=self._follow, name="trajopt mirror", daemon=True)
        self._follower.start()

    @property
    def lost(self) -> str:
        """The reason why the connection is lost; empty while it works."""
        return self._lost

    def _end(self) -> None:
        self._follower.join()
        self._source.close()

    def _follow(self) -> None:
        wait = PERIOD
        while not self._closed.wait(wait):
            try:
                self._hear()
                wait, self._lost = PERIOD, ""
            except TrajoptError as error:
                wait, self._lost = AGAIN, str(error)
            self._say()

    def _hear(self) -> None:
        state = self._source.state()
        self._heard = time.monotonic()
        before, self.state = self.state, state
        if state.revision != before.revision:
            self.scene = self._source.scene()
            columns = self.scene.robot.index(self._joints)
            self._scene.change(self._whole(self.scene), state.positions[columns])
        elif _same(before, state):
            return
        self._show()

    @property
    def nearest(self) -> tuple[Nearest, ...]:
        """The nearest pairs, the nearest first."""
        return self._scene.nearest

    def _whole(self, scene: Scene) -> ReducedModel:
        return whole_robot(scene, self._joints, self.state.positions)

    def _at(self, positions: Floats) -> JointPlacements:
        columns = self.scene.robot.index(self._joints)
        return self._scene.kinematics(positions[:, columns])

    def _show(self) -> None:
        state, columns = self.state, self.scene.robot.index(self._joints)
        with self._server.atomic():
            self._scene.show(state.positions[columns])
            ahead = None if state.ahead is None else self._at(state.ahead)
            self._ghost.stand(ahead)
            self._trail.show(None if ahead is None else self._scene.line_of(self._hand, ahead))
        self._events.content = events_html(state.events, EVENTS) if state.events else ""
        self._say()

    def _say(self) -> None:
        since = time.monotonic() - self._heard
        if self._lost and since > OLD:
            words = [f"No answer for {since:.0f} s: the picture is old.", self._lost]
            self._text.content = block_html("No answer", words, TOUCHING)
            return
        title, colour = (
            ("The robot is being driven", NARROW) if self.state.driven else ("The robot stands", SAFE)
        )
        self._text.content = block_html(title, [f"As it is at {self._source.url}"], colour)


def _same(one: RemoteState, other: RemoteState) -> bool:
    return (
        np.array_equal(one.positions, other.positions)
        and one.driven == other.driven
        and len(one.events) == len(other.events)
        and (one.ahead is None) == (other.ahead is None)
    )


AHEAD = 25
"""Number of configurations along the rest of a motion."""
PUBLISHED_EVENTS = 12
"""Number of published events, the latest ones."""
TIMEOUT = 10.0
"""Time-out of a silent connection [s]."""
LARGEST = 4096
"""Largest body of a request [bytes]; none is needed."""
LOCAL = ("127.0.0.1", "localhost", "[::1]")


@checked_class
class RunPublisher:
    """Publishes a run: `run(problem, watch=publisher.look)`. A context manager; or call `close`.

    Attributes:
        url: Address for `trajopt view --mirror`.
    """

    def __init__(self, problem: Problem, *, port: int = 8090, host: str = "127.0.0.1") -> None:
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

    def __enter__(self) -> "RunPublisher":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def look(self, watched: CommitLoop) -> None:
        """Read the state of the supervisor, always the same, after each cycle."""
        self._logbook.look(watched)

    def close(self) -> None:
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def robot(self) -> dict[str, object]:
        """Return the robot as a message."""
        return message_of(self._problem.scene.robot, {})

    def scene(self) -> dict[str, object]:
        return message_of(self._scene(), {"robot": self._problem.scene.robot})

    def state(self) -> RemoteState:
        moment, reduced = self._moment(), self._problem.reduced
        if moment is None:
            return RemoteState(revision=0, positions=self._problem.start_positions, driven=False)
        return RemoteState(
            revision=self._revised(moment),
            positions=reduced.all_positions(moment.positions),
            driven=moment.stop is not None,
            ahead=None if moment.plan is None else self._ahead(moment.plan),
            events=moment.events[-PUBLISHED_EVENTS:],
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
        scene = moment.sighting.world.scene
        now = (moment.sighting, moment.time if scene.changing else 0.0)
        with self._lock:
            if now[0] is not self._told[0] or now[1] != self._told[1]:
                self._told, self._revision = now, self._revision + 1
            return self._revision

    def _ahead(self, plan: Trajectory) -> Floats:
        along = plan(np.linspace(0.0, plan.duration, AHEAD))
        return np.array([self._problem.reduced.all_positions(each) for each in along])


def _handler_of(publisher: RunPublisher, host: str) -> type[BaseHTTPRequestHandler]:
    """Return the handler of requests; on this machine only for its own host names (DNS rebinding)."""

    class Handler(BaseHTTPRequestHandler):
        timeout = TIMEOUT

        def do_GET(self) -> None:
            self._answer({"/state": lambda: publisher.state().as_dict()})

        def do_POST(self) -> None:
            self._answer({"/robot": publisher.robot, "/scene": publisher.scene})

        def log_message(self, format: str, *args: Any) -> None:
            """Do not log to standard error."""

        def _answer(self, known: dict[str, Any]) -> None:
            # The body is not needed; unread, it would reset the connection.
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
