"""The page: a robot, its surroundings and a motion, with a time slider, served on a local port."""

import atexit
import threading
import time
from contextlib import redirect_stdout
from io import StringIO
from socket import create_server
from typing import TYPE_CHECKING, overload

import numpy as np

from trajopt.arrays import Floats, one_of
from trajopt.errors import MissingExtra, ProblemError, ShapeError, shown
from trajopt.errors.arguments import checked
from trajopt.model.placement import Placement
from trajopt.model.reduced import Planned, ReducedModel, model_and_trajectory
from trajopt.model.trajectory import Trajectory
from trajopt.query import Kinematics
from trajopt.view.clearance import ClearanceQuery, Nearest
from trajopt.view.drawing import Drawing
from trajopt.view.readout import clearance_html, joints_html

if TYPE_CHECKING:
    from viser import GuiEvent, GuiSliderHandle, ViserServer

FRAME_TIME = 1 / 30
"""Time between two frames while playing [s]."""
ASPECT = 1.0
"""Width over height that the motion is framed for: that of what the controls leave free in the middle."""
LAST_PORT = 65535


@overload
def view(motion: Planned, *, port: int = 8080, host: str = "127.0.0.1") -> "Viewer": ...
@overload
def view(
    motion: ReducedModel, trajectory: Trajectory, *, port: int = 8080, host: str = "127.0.0.1"
) -> "Viewer": ...
def view(
    motion: Planned | ReducedModel,
    trajectory: Trajectory | None = None,
    *,
    port: int = 8080,
    host: str = "127.0.0.1",
) -> "Viewer":
    """Serve a page that shows a plan, or any trajectory of a reduced model; returns at once.

    Args:
        motion: A plan, or a result that has one; or the reduced model (robot and scene) of a trajectory.
        trajectory: The motion of the group's joints; the plan's own when None.
        port: Port to serve on; the next free one if it is taken.
        host: Address to serve on; "0.0.0.0" lets other machines look too.

    Returns:
        The viewer: open its `url` in a browser; `wait()` keeps a script alive.

    Raises:
        MissingExtra: If viser is not installed.
        PlanningFailed: If the result has no plan.
        ProblemError: If nothing can be served on this host or port.
        ShapeError: If the trajectory moves other joints than the group's.
    """
    reduced, trajectory = model_and_trajectory("view", motion, trajectory)
    try:
        from viser import ViserServer
    except ImportError as error:
        raise MissingExtra("viser", "view") from error
    if trajectory.joint_names != reduced.joint_names:
        raise ShapeError("trajectory", f"moves {trajectory.joint_names}, the group is {reduced.joint_names}")
    _check_address(one_of("host", host, str), port)
    with _unannounced():
        server = ViserServer(host, port, "trajopt", verbose=False)
    return Viewer(server, reduced, trajectory)


def _unannounced() -> redirect_stdout[StringIO]:
    """Keep viser's own announcements, which `verbose` does not stop, out of the caller's output."""
    return redirect_stdout(StringIO())


def _check_address(host: str, port: int) -> None:
    """Refuse addresses that cannot be served on: the server would wait for its own start.

    Raises:
        ProblemError: If the port is not a port number, or the address is not this machine's.
    """
    if type(port) is not int or not 0 <= port <= LAST_PORT:
        raise ProblemError(f"port must be a whole number from 0 to {LAST_PORT}, is {shown(port)}")
    try:
        create_server((host, 0)).close()
    except (OSError, UnicodeError) as error:
        raise ProblemError(f"view: nothing can be served on host {shown(host)}: {error}") from error


class Viewer:
    """A page that shows a motion; `view` opens one.

    Attributes:
        url: Address of the page.
    """

    def __init__(self, server: "ViserServer", reduced: ReducedModel, trajectory: Trajectory) -> None:
        """Draw the scene and the controls, and show the beginning."""
        host = "localhost" if server.get_host() == "0.0.0.0" else server.get_host()
        self.url = f"http://{host}:{server.get_port()}"
        self._server = server
        self._reduced = reduced
        self._trajectory = trajectory
        self._time = 0.0
        self._lock = threading.RLock()
        self._playing, self._closed = threading.Event(), threading.Event()
        self._clearance = ClearanceQuery(reduced, trajectory.duration)
        start = self._kinematics(0.0)
        self._drawing = Drawing(server, self._clearance.reduced, start)
        if self._clearance.timed is not None:
            self._drawing.draw_halos(self._clearance.timed)
        self._look(reduced, trajectory)
        # A joint that slides has no angular velocity.
        turns = np.linalg.norm(start.jacobian[0, 3:], axis=0) > 0.5
        columns = [list(reduced.model.names).index(name) - 1 for name in reduced.joint_names]
        self._revolute = tuple(bool(turns[column]) for column in columns)
        self._add_controls()
        self._refresh(0.0)
        atexit.register(self.close)  # runs before viser's own, which would announce it
        self._player = threading.Thread(target=self._play, name="trajopt viewer", daemon=True)
        self._player.start()

    @property
    def time(self) -> float:
        """Time that is shown [s]."""
        return self._time

    @property
    def positions(self) -> Floats:
        """Positions of the group's joints that are shown, shape (n,) [rad | m]."""
        return self._trajectory(self._time)

    @property
    def nearest(self) -> Nearest | None:
        """The pair with the smallest clearance at the time that is shown."""
        return self._nearest

    @checked
    def joint_placement(self, joint: str) -> Placement:
        """Return where a joint is drawn, in the world."""
        return self._drawing.joint_placement(joint)

    @checked
    def show(self, t: float) -> None:
        """Show the motion at a time [s], clipped to its duration."""
        with self._lock:
            self._refresh(t)
            self._slider.value = self._time

    def play(self) -> None:
        """Play the motion, from the beginning if it is at its end."""
        with self._lock:
            if self._time >= self._trajectory.duration:
                self.show(0.0)
            self._button.label = "Pause"
            self._playing.set()

    def pause(self) -> None:
        """Stop where the motion is."""
        with self._lock:
            self._button.label = "Play"
            self._playing.clear()

    @checked
    def wait(self, seconds: float | None = None) -> None:
        """Block until Ctrl-C, until `close` is called, or until the seconds are over."""
        try:
            self._closed.wait(seconds)
        except KeyboardInterrupt:
            self.close()

    def close(self) -> None:
        """Stop serving the page."""
        with self._lock:
            if self._closed.is_set():
                return
            self._closed.set()
            self._playing.set()
        atexit.unregister(self.close)
        self._player.join()  # its frames would hold native objects beyond the interpreter's end
        with _unannounced():
            self._server.stop()

    def __repr__(self) -> str:
        """Say where the page is."""
        return f"Viewer({shown(self.url)}, {self._trajectory})"

    def _look(self, reduced: ReducedModel, trajectory: Trajectory) -> None:
        """Draw the tools' paths, look from where least is hidden, and through what still is in the way."""
        from trajopt.simulate.camera import FIELD_OF_VIEW  # MuJoCo takes a second to import
        from trajopt.simulate.motion import motion_of
        from trajopt.simulate.posed import tool_paths
        from trajopt.simulate.viewpoint import look_at

        motion = motion_of(reduced, trajectory)
        self._drawing.draw_tool_paths(tool_paths(reduced, motion))
        view = look_at(reduced, motion, ASPECT)
        self._hiding = view.hiding
        self._drawing.make_translucent(view.hiding)
        camera = self._server.initial_camera
        camera.look_at, camera.position = view.camera.target, view.camera.position
        camera.fov = float(FIELD_OF_VIEW)

    def _add_controls(self) -> None:
        gui, duration = self._server.gui, self._trajectory.duration
        gui.configure_theme(show_logo=False, show_share_button=False, brand_color=(0x44, 0x77, 0xAA))
        step = 0.01 if duration > 1.0 else 0.001
        # The last step may lie beyond the end, which is what it shows then.
        last = round(float(np.ceil(duration / step)) * step, 3)
        self._slider = gui.add_slider("time [s]", 0.0, last, step, 0.0)
        self._button = gui.add_button("Play")
        self._speed = gui.add_slider("speed", 0.1, 2.0, 0.1, 1.0)
        shapes = gui.add_checkbox("collision shapes", False)
        through = gui.add_checkbox("see through objects", False)
        self._clearance_text = gui.add_html("")
        self._joints_text = gui.add_html("")

        @self._slider.on_update
        def _(event: "GuiEvent[GuiSliderHandle[float]]") -> None:
            if event.client is not None:
                self.pause()
                with self._lock:
                    # Events may overtake each other: the slider itself holds the last value.
                    self._refresh(self._slider.value)

        @self._button.on_click
        def _(_: object) -> None:
            if self._playing.is_set():
                self.pause()
            else:
                self.play()

        @shapes.on_update
        def _(_: object) -> None:
            self._drawing.show_collision_shapes(shapes.value)

        @through.on_update
        def _(_: object) -> None:
            everything = self._reduced.scene.objects
            self._drawing.make_translucent(everything if through.value else self._hiding)

    def _refresh(self, t: float) -> None:
        """Move everything but the slider to a time."""
        with self._lock:
            shown = min(max(float(t), 0.0), self._trajectory.duration)
            positions = self._trajectory(shown)
            kinematics, timed = self._kinematics(shown), self._clearance.timed
            self._nearest = self._clearance.nearest(shown, positions)
            with self._server.atomic():
                self._drawing.move(kinematics)
                if timed is not None:
                    self._drawing.show_changing(timed, shown)
                self._drawing.point_out(self._nearest)
            self._clearance_text.content = clearance_html(self._nearest)
            self._joints_text.content = joints_html(self._reduced.limits, positions, self._revolute)
            self._time = shown

    def _kinematics(self, t: float) -> Kinematics:
        seen = self._clearance
        return seen.query.kinematics(seen.positions(np.array([t]), self._trajectory(t)[None]))

    def _play(self) -> None:
        """Advance while playing (body of the thread)."""
        last = time.monotonic()
        while not self._closed.is_set():
            if not self._playing.is_set():
                self._playing.wait()
                last = time.monotonic()
            now = time.monotonic()
            with self._lock:
                if self._playing.is_set() and not self._closed.is_set():
                    self.show(self._time + (now - last) * self._speed.value)
                    if self._time >= self._trajectory.duration:
                        self.pause()
            last = now
            self._closed.wait(FRAME_TIME)
