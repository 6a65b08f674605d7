"""The browser as an input of a servo: sliders for tool and joints, a gizmo, a speed, a dead man's button.

Sliders range from -1 to 1: `ServoOptions.scaling` and `turning` convert to m/s and rad/s.
"""

import threading
import time
from enum import Enum

import numpy as np

from trajopt.driving.commit_loop import CommitLoop
from trajopt.driving.recording import Logbook, Sighting
from trajopt.driving.servo_command import Command, JointVelocities, Pose, Twist
from trajopt.driving.servo_input import Order
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.problem.problem import Problem
from trajopt.scene.reducing import tool_frame
from trajopt.values.errors.arguments import checked, checked_class
from trajopt.values.placement import WORLD, PlacementLike, as_placement, scalar_first
from trajopt.values.placement import placement as placed
from trajopt.viewer.playback import FRAME_TIME
from trajopt.viewer.readout import clearance_html, events_html
from trajopt.viewer.run_viewer import EVENTS, RunDrawing, look_from_the_best_side
from trajopt.viewer.server import Served, open_server

AXES = ("x", "y", "z", "about x", "about y", "about z")
SIGNALS = 20.0
"""Signals per second of a held button."""
HELD = 0.2
"""Time-out of the last signal [s]: three signals may be lost."""
GIZMO = 0.25
"""Size of the gizmo [m]."""
LET_GO = "the button was let go"


class Lead(Enum):
    """Kind of command that leads the robot."""

    TOOL = "tool"
    JOINTS = "joints"
    GIZMO = "gizmo"


@checked
def servo_page(
    problem: Problem, *, frame: str = "", axes: str = WORLD, port: int = 8080, host: str = "127.0.0.1"
) -> "ServoPage":
    """Serve a page that leads a robot, and shows it, as `view` does; by default the group's own tool.

    Args:
        axes: Frame of the tool sliders' axes: "world", or the tool's own.

    Raises:
        FrameNotFound: If there is no such tool.
    """
    first = Sighting(since=-np.inf, world=WorldSnapshot(problem.scene, 0.0))
    tool = frame or tool_frame(problem.reduced)
    problem.reduced.attachment(tool)
    drawing = RunDrawing(open_server(host, port), problem.group, problem.start_positions, first)
    return ServoPage(drawing, tool, axes)


@checked_class
class ServoPage(Served):
    """A page that leads a robot; `servo_page` opens one. An input of a servo: `guide(servo, page, ...)`."""

    def __init__(self, drawing: RunDrawing, tool: str, axes: str) -> None:
        server = drawing.server
        super().__init__(server)
        self._drawing, self._tool, self._axes = drawing, tool, axes
        self._logbook, self._shown = Logbook(), 0
        self._held, self._speed = -np.inf, 1.0
        look_from_the_best_side(server, drawing.reduced, None)
        gui = server.gui
        self._button = gui.add_button("Drive (hold)", color="green")
        self._speeds = gui.add_slider("speed", 0.0, 1.0, 0.05, 1.0)
        self._lead = gui.add_dropdown("lead by", tuple(each.value for each in Lead))
        self._twist = [gui.add_slider(name, -1.0, 1.0, 0.05, 0.0) for name in AXES]
        names = drawing.reduced.joint_names
        self._joints = {name: gui.add_slider(name, -1.0, 1.0, 0.05, 0.0, visible=False) for name in names}
        middle = gui.add_button("sliders to the middle, gizmo to the tool")
        self._gizmo = server.scene.add_transform_controls("/gizmo", scale=GIZMO, visible=False)
        self._clearance_text, self._events_text = gui.add_html(""), gui.add_html("")
        self._gizmo_to_the_tool()
        self._button.on_hold(self._hold, callback_hz=SIGNALS)  # pyright: ignore[reportUnknownMemberType]

        @self._lead.on_update
        def _(_: object) -> None:
            lead = Lead(self._lead.value)
            with self._server.atomic():
                for each in self._twist:
                    each.visible = lead is Lead.TOOL
                for each in self._joints.values():
                    each.visible = lead is Lead.JOINTS
                self._gizmo.visible = lead is Lead.GIZMO
                if lead is Lead.GIZMO:
                    self._gizmo_to_the_tool()

        @middle.on_click
        def _(_: object) -> None:
            for each in (*self._twist, *self._joints.values()):
                each.value = 0.0
            self._gizmo_to_the_tool()

        self._follower = threading.Thread(target=self._follow, name="trajopt servo page", daemon=True)
        self._follower.start()

    def read(self, since: float) -> Order | None:
        speed = self._speeds.value
        new = None if speed == self._speed else speed
        self._speed = speed
        if time.monotonic() - self._held > HELD:
            return Order(speed=new, released=LET_GO)
        return Order(speed=new, command=self._command())

    def look(self, watched: CommitLoop) -> None:
        """Look at the servo after a tick; it is drawn soon after, in another thread."""
        self._logbook.look(watched)

    def move_gizmo(self, placement: PlacementLike) -> None:
        """Put the gizmo somewhere in the world."""
        where = as_placement("placement", placement)
        self._gizmo.position, self._gizmo.wxyz = where.translation, scalar_first(where)

    def _end(self) -> None:
        self._follower.join()

    def _hold(self, event: object) -> None:
        del event
        self._held = time.monotonic()

    def _command(self) -> Command:
        match Lead(self._lead.value):
            case Lead.TOOL:
                said = np.array([each.value for each in self._twist], dtype=np.float64)
                return Twist(said[:3], said[3:], self._axes)
            case Lead.JOINTS:
                return JointVelocities({name: float(each.value) for name, each in self._joints.items()})
            case Lead.GIZMO:
                w, x, y, z = self._gizmo.wxyz
                return Pose(placed(self._gizmo.position, quaternion=(x, y, z, w)))

    def _gizmo_to_the_tool(self) -> None:
        reduced, looked = self._drawing.reduced, self._logbook.samples
        at = self._logbook.moment.positions if looked else reduced.start_positions
        self.move_gizmo(reduced.scene.placement_of(self._tool, reduced.all_positions(at)))

    def _follow(self) -> None:
        while not self._closed.wait(FRAME_TIME):
            looks = self._logbook.samples
            if looks == self._shown:
                continue
            self._shown, moment = looks, self._logbook.moment
            self._drawing.show(moment)
            self._clearance_text.content = clearance_html(self._drawing.nearest)
            self._events_text.content = events_html(moment.events, EVENTS)
