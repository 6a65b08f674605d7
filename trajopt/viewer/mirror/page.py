"""The page of a mirror: the robot as it is at this moment, elsewhere."""

import threading
import time
from typing import TYPE_CHECKING

import numpy as np

from trajopt.geometry import JointPlacements
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model, tool_frame
from trajopt.scene.scene import Scene
from trajopt.scene.whole_robot import whole_robot
from trajopt.values.arrays import Floats
from trajopt.values.errors import TrajoptError
from trajopt.values.errors.arguments import checked
from trajopt.viewer import palette
from trajopt.viewer.clearance import ClearanceQuery, Nearest
from trajopt.viewer.drawing import Drawing, Ghost, Trail
from trajopt.viewer.live.nearest_drawing import PAIRS, NearestDrawing, telling_pairs
from trajopt.viewer.live.objects_drawing import ObjectsDrawing
from trajopt.viewer.live.words import block_html
from trajopt.viewer.live.workbench import chosen_group
from trajopt.viewer.mirror.state import Source, State
from trajopt.viewer.palette import NARROW, SAFE, TOUCHING
from trajopt.viewer.readout import events_html
from trajopt.viewer.run_viewer import look_from_the_best_side
from trajopt.viewer.server import Served, open_server

if TYPE_CHECKING:
    from trajopt.viewer.guarded_server import GuardedServer

PERIOD = 1 / 15
"""Polling period [s]: a server updates its robot's state ten times a second."""
AGAIN = 1.0
"""Delay before another request without an answer [s]."""
OLD = 1.0
"""Age from which a state is marked as old [s]."""
LONG = 1e6
"""Assumed duration of a posture [s]."""
EVENTS = 8
"""Number of listed events, the latest ones."""


@checked
def mirror_view(url: str, *, token: str = "", port: int = 8080, host: str = "127.0.0.1") -> "MirrorView":
    """Serve a page that shows a remote robot and its known surroundings; returns immediately.

    Args:
        url: Of a session of `trajopt serve` ("http://127.0.0.1:8080/sessions/ID"), or of a published run
            (`trajopt run --publish`, or a `Publisher`).
        token: Access token of the server.
        port: Port to serve on; the next free one if it is taken.
        host: Address to serve on; "0.0.0.0" lets other machines view the page too.

    Raises:
        MissingExtra: If viser or httpx is not installed.
        ServerError: If the address does not answer, or refuses.
        FileFormatError: If the answer cannot be mirrored.
        ProblemError: If the port cannot be opened on this host.
    """
    source = Source(url, token=token)
    try:
        state, scene = source.state(), source.scene()
        return MirrorView(open_server(host, port), source, state, scene)
    except BaseException:
        source.close()
        raise


class MirrorView(Served):
    """A page that shows a remote robot; `mirror_view` opens one.

    Attributes:
        url: Address of the page.
        state: The latest state.
        scene: The known surroundings of the robot.
        nearest: The nearest pairs, the nearest first.
    """

    def __init__(self, server: "GuardedServer", source: Source, state: State, scene: Scene) -> None:
        """Draw the robot, and start polling."""
        super().__init__(server)
        self._source, self.state, self.scene = source, state, scene
        self._joints = tuple(name for name in scene.robot.joint_names if name not in scene.robot.mimics)
        self._heard, self._lost = time.monotonic(), ""
        self.nearest: tuple[Nearest, ...] = ()
        self._take(scene)
        reduced, robot = self._reduced, scene.robot
        self._hand = tool_frame(reduce_model(scene, chosen_group(robot), state.positions))
        look_from_the_best_side(server, reduced, None, back=1.35, aside=0.16)
        here = self._clearance.query.kinematics(reduced.start_positions[None])
        self._robot = Drawing(server, reduced, here, objects=False)
        self._objects = ObjectsDrawing(server, lambda _: None, lambda _: None)
        self._objects.show(reduced, here)
        self._near = NearestDrawing(server)
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
        """Poll, and show changes (body of the thread)."""
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
            self._take(self.scene)
            self._objects.show(self._reduced, self._at(state.positions[None]))
        elif _same(before, state):
            return
        self._show()

    def _take(self, scene: Scene) -> None:
        self._reduced: ReducedModel = whole_robot(scene, self._joints, self.state.positions)
        self._clearance = ClearanceQuery(self._reduced, LONG)

    def _at(self, positions: Floats) -> JointPlacements:
        """Return the configurations for positions of all joints, shape (k, number of joints)."""
        columns = self.scene.robot.index(self._joints)
        return self._clearance.query.kinematics(positions[:, columns])

    def _show(self) -> None:
        state, columns = self.state, self.scene.robot.index(self._joints)
        here = self._at(state.positions[None])
        self.nearest = telling_pairs(self._clearance, state.positions[columns], PAIRS)
        with self._server.atomic():
            self._robot.move(here)
            self._objects.move(self._reduced, here)
            self._near.show(self.nearest)
            ahead = None if state.ahead is None else self._at(state.ahead)
            self._ghost.stand(ahead)
            self._trail.show(None if ahead is None else self._line(ahead))
        self._events.content = events_html(state.events, EVENTS) if state.events else ""
        self._say()

    def _line(self, along: JointPlacements) -> Floats:
        joint, held = self._reduced.attachment(self._hand)
        return along.rotation[:, joint] @ held.translation + along.translation[:, joint]

    def _say(self) -> None:
        """Show whether the robot moves, or that the state is old."""
        since = time.monotonic() - self._heard
        if self._lost and since > OLD:
            words = [f"Nothing was heard for {since:.0f} s: what is shown is old.", self._lost]
            self._text.content = block_html("No answer", words, TOUCHING)
            return
        title, colour = (
            ("The robot is being driven", NARROW) if self.state.driven else ("The robot stands", SAFE)
        )
        self._text.content = block_html(title, [f"As it is at {self._source.url}"], colour)


def _same(one: State, other: State) -> bool:
    return (
        np.array_equal(one.positions, other.positions)
        and one.driven == other.driven
        and len(one.events) == len(other.events)
        and (one.ahead is None) == (other.ahead is None)
    )
