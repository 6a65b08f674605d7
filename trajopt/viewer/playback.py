"""Playback: time slider, play button and speed; pages of one or several motions."""

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, cast, overload

import numpy as np

from trajopt.scene.planned_robot import Planned, model_and_trajectory
from trajopt.scene.reduced import ReducedModel
from trajopt.tasks.sequence import MotionSequence
from trajopt.values.arrays import Floats
from trajopt.values.errors import ShapeError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement
from trajopt.values.trajectory import Trajectory
from trajopt.viewer.clearance import Nearest
from trajopt.viewer.readout import block_html, clearance_html, joints_html, stages_html
from trajopt.viewer.scene_view import SceneView
from trajopt.viewer.server import Served, open_server

if TYPE_CHECKING:
    from viser import GuiEvent, GuiSliderHandle, ViserServer

    from trajopt.viewer.guarded_server import GuardedServer

FRAME_TIME = 1 / 30
"""Time between two frames while playing [s]."""


class Playback:
    """A time slider from 0 to a duration, scrubbed by hand or played."""

    def __init__(
        self,
        server: "ViserServer",
        duration: float,
        draw: Callable[[float], None],
        taken: Callable[[], None] = lambda: None,
    ) -> None:
        self.time, self.lock = 0.0, threading.RLock()
        self._duration, self._draw = duration, draw
        self._playing, self._closed = threading.Event(), threading.Event()
        gui = server.gui
        step = 0.01 if duration > 1.0 else 0.001
        # The last step may lie beyond the end, which is what it shows then.
        self._slider = gui.add_slider("time [s]", 0.0, _last(duration, step), step, 0.0)
        self._button = gui.add_button("Play")
        self._speed = gui.add_slider("speed", 0.1, 2.0, 0.1, 1.0)

        @self._slider.on_update
        def _(event: "GuiEvent[GuiSliderHandle[float]]") -> None:
            if event.client is not None:
                taken()
                self.pause()
                with self.lock:
                    # Events may overtake each other: the slider itself holds the last value.
                    self.refresh(self._slider.value)

        @self._button.on_click
        def _(_: object) -> None:
            if self._playing.is_set():
                self.pause()
            else:
                taken()
                self.play()

        self._player = threading.Thread(target=self._play, name="trajopt viewer", daemon=True)
        self._player.start()

    def show(self, t: float) -> None:
        with self.lock:
            self.refresh(t)
            self._slider.value = self.time

    def refresh(self, t: float) -> None:
        with self.lock:
            self.time = min(max(float(t), 0.0), self._duration)
            self._draw(self.time)

    def lengthen(self, duration: float) -> None:
        """Extend the duration [s]."""
        with self.lock:
            self._duration = duration
            self._slider.max = max(_last(duration, self._slider.step), self._slider.max)

    def replace(self, duration: float) -> None:
        with self.lock:
            self.pause()
            self._duration = duration
            self._slider.max = max(_last(duration, self._slider.step), self._slider.step)
            self._slider.disabled = self._button.disabled = self._speed.disabled = duration <= 0.0
            self._slider.value, self.time = 0.0, 0.0

    def play(self) -> None:
        with self.lock:
            if self.time >= self._duration:
                self.show(0.0)
            self._button.label = "Pause"
            self._playing.set()

    def pause(self) -> None:
        with self.lock:
            self._button.label = "Play"
            self._playing.clear()

    def close(self) -> None:
        with self.lock:
            self._closed.set()
            self._playing.set()
        self._player.join()

    def _play(self) -> None:
        last = time.monotonic()
        while not self._closed.is_set():
            if not self._playing.is_set():
                self._playing.wait()
                last = time.monotonic()
            now = time.monotonic()
            with self.lock:
                if self._playing.is_set() and not self._closed.is_set():
                    self.show(self.time + (now - last) * self._speed.value)
                    if self.time >= self._duration:
                        self.pause()
            last = now
            self._closed.wait(FRAME_TIME)


def _last(duration: float, step: float) -> float:
    return round(float(np.ceil(duration / step)) * step, 3)


class PlayedPage(Served):
    """A page with a time slider."""

    _playback: Playback

    @property
    def time(self) -> float:
        return self._playback.time

    @checked
    def show(self, t: float) -> None:
        self._leave_live()
        self._playback.show(t)

    def play(self) -> None:
        self._leave_live()
        self._playback.play()

    def pause(self) -> None:
        self._playback.pause()

    def _end(self) -> None:
        self._playback.close()

    def _leave_live(self) -> None:
        """Stop following a run that goes on; other pages have nothing to leave."""


@overload
def view(motion: Planned[ReducedModel], *, port: int = 8080, host: str = "127.0.0.1") -> "Viewer": ...
@overload
def view(motion: MotionSequence[Any], *, port: int = 8080, host: str = "127.0.0.1") -> "SequenceViewer": ...
@overload
def view(
    motion: ReducedModel, trajectory: Trajectory, *, port: int = 8080, host: str = "127.0.0.1"
) -> "Viewer": ...
def view(
    motion: Planned[ReducedModel] | MotionSequence[Any] | ReducedModel,
    trajectory: Trajectory | None = None,
    *,
    port: int = 8080,
    host: str = "127.0.0.1",
) -> "Viewer | SequenceViewer":
    """Serve a page that shows a plan, a task, or any trajectory of a reduced model; returns immediately.

    Args:
        motion: A plan, or a result of one or several motions; or the reduced model of a trajectory.
        trajectory: The motion of the group's joints; the plan's own if None.
        port: The next free one if it is taken.
        host: Address to serve on; "0.0.0.0" lets other machines view the page too.

    Returns:
        The viewer: open its `url` in a browser; `wait()` keeps a script alive.

    Raises:
        MissingExtra: Without viser.
        PlanningFailed: If the result has no plan.
        ProblemError: If the port cannot be opened on this host.
        ShapeError: If the trajectory moves other joints than the group's.
    """
    if trajectory is None and isinstance(motion, MotionSequence):
        motion.require()
        return SequenceViewer(open_server(host, port), motion)
    single = cast("Planned[ReducedModel] | ReducedModel", motion)
    reduced, trajectory = model_and_trajectory("view", single, trajectory, ReducedModel)
    if trajectory.joint_names != reduced.joint_names:
        raise ShapeError("trajectory", f"moves {trajectory.joint_names}, the group is {reduced.joint_names}")
    return Viewer(open_server(host, port), reduced, trajectory)


class Viewer(PlayedPage):
    """A page that shows a motion; `view` opens one."""

    def __init__(self, server: "GuardedServer", reduced: ReducedModel, trajectory: Trajectory) -> None:
        from trajopt.simulation.sampled_motion import motion_of

        super().__init__(server)
        self._reduced = reduced
        self._trajectory = trajectory
        self._scene = SceneView(server, reduced, trajectory(0.0), duration=trajectory.duration)
        self._scene.look(motion_of(reduced, trajectory))
        start = self._scene.kinematics(0.0, trajectory(0.0))
        # A joint that slides has no angular velocity.
        turns = np.linalg.norm(start.jacobian[0, 3:], axis=0) > 0.5
        columns = [list(reduced.model.names).index(name) - 1 for name in reduced.joint_names]
        self._revolute = tuple(bool(turns[column]) for column in columns)
        self._playback = Playback(server, trajectory.duration, self._draw)
        self._add_controls()
        self._playback.refresh(0.0)

    @property
    def positions(self) -> Floats:
        return self._trajectory(self.time)

    @property
    def nearest(self) -> Nearest | None:
        """The pair with the smallest clearance at the shown time."""
        return self._scene.nearest

    @checked
    def joint_placement(self, joint: str) -> Placement:
        """Return the drawn placement of a joint in the world."""
        return self._scene.drawing.joint_placement(joint)

    def __repr__(self) -> str:
        return f"Viewer({shown(self.url)}, {self._trajectory})"

    def _add_controls(self) -> None:
        gui = self._server.gui
        shapes = gui.add_checkbox("collision shapes", False)
        through = gui.add_checkbox("see through objects", False)
        self._clearance_text = gui.add_html("")
        self._joints_text = gui.add_html("")

        @shapes.on_update
        def _(_: object) -> None:
            self._scene.drawing.show_collision_shapes(shapes.value)

        @through.on_update
        def _(_: object) -> None:
            everything = self._reduced.scene.objects
            self._scene.drawing.make_translucent(everything if through.value else self._scene.hiding)

    def _draw(self, t: float) -> None:
        positions = self._trajectory(t)
        self._clearance_text.content = clearance_html(self._scene.show(t, positions))
        self._joints_text.content = joints_html(self._reduced.limits, positions, self._revolute)


class SequenceViewer(PlayedPage):
    """A page that shows several motions in order, each in the scene of its time."""

    def __init__(self, server: "GuardedServer", sequence: MotionSequence[Any]) -> None:
        from trajopt.simulation.sampled_motion import motion_of

        super().__init__(server)
        segments, self._rows = sequence.require(), sequence.tree
        self._plans = [segment.result.require() for segment in segments]
        self._titles = [segment.title for segment in segments]
        ends = np.cumsum([segment.duration for segment in segments])
        self._begins, self._duration = np.concatenate(([0.0], ends[:-1])), float(ends[-1])
        self._scenes: dict[int, SceneView] = {}
        longest = max(range(len(self._plans)), key=lambda index: self._plans[index].trajectory.duration)
        plan = self._plans[longest]
        self._shown(longest).look(motion_of(plan.problem.reduced, plan.trajectory), paths=False)
        self._playback = Playback(server, self._duration, self._draw)
        self._text = server.gui.add_html("")
        self._clearance_text = server.gui.add_html("")
        self._playback.refresh(0.0)

    def __repr__(self) -> str:
        return f"SequenceViewer({shown(self.url)}, {len(self._plans)} motions, {self._duration:.3g} s)"

    @property
    def motion(self) -> int:
        return self._motion_at(self.time)

    def _motion_at(self, t: float) -> int:
        return max(int(np.searchsorted(self._begins, t, side="right")) - 1, 0)

    def _shown(self, index: int) -> SceneView:
        plan = self._plans[index]
        if index not in self._scenes:
            first = plan.trajectory(0.0)
            root = f"/motion {index}"
            self._scenes[index] = SceneView(
                self._server, plan.problem.reduced, first, duration=plan.trajectory.duration, root=root
            )
        for other, scene in self._scenes.items():
            scene.drawing.show(other == index)
        return self._scenes[index]

    def _draw(self, t: float) -> None:
        index = self._motion_at(t)
        plan = self._plans[index]
        since = min(t - float(self._begins[index]), plan.trajectory.duration)
        nearest = self._shown(index).show(since, plan.trajectory(since))
        motion = block_html(f"Motion {index + 1} of {len(self._plans)}", [self._titles[index]])
        self._text.content = motion + stages_html(self._rows, self._duration, t)
        self._clearance_text.content = clearance_html(nearest)
