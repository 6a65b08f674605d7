"""The page of a run, live or recorded, with a time slider."""

import threading
from typing import TYPE_CHECKING

import numpy as np

from trajopt.driving.commit_loop import CommitLoop
from trajopt.driving.recording import Logbook, RecordedMoment, Recording, Sighting
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.geometry import Evaluator, evaluator
from trajopt.problem.problem import Problem
from trajopt.scene.reducing import reduce_model, tool_frame
from trajopt.values.arrays import Floats
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory
from trajopt.viewer import palette
from trajopt.viewer.clearance import Nearest
from trajopt.viewer.drawing import POINTS, Drawing, Ghost, Trail
from trajopt.viewer.palette import Rgb
from trajopt.viewer.playback import FRAME_TIME, Playback, PlayedPage
from trajopt.viewer.readout import clearance_html, events_html
from trajopt.viewer.scene_view import SceneView, look_from_the_best_side
from trajopt.viewer.server import open_server

if TYPE_CHECKING:
    from viser import ViserServer

    from trajopt.viewer.guarded_server import GuardedServer


class RunDrawing:
    """The measured robot, ghosts at its stop and goal, and the known world.

    Attributes:
        reduced: The robot in the first known world.
    """

    def __init__(self, server: "GuardedServer", group: str, start: Floats, first: Sighting) -> None:
        self.server, self._group, self._start = server, group, start
        self.reduced = reduce_model(first.world.scene, group, start)
        self.nearest: Nearest | None = None
        self._query = evaluator(self.reduced)
        here = self._query.kinematics(self.reduced.start_positions[None])
        self._robot = Drawing(server, self.reduced, here, objects=False)
        # The plan begins with the way to the stop, or nearly: that is seen on either side of it.
        self._stop = Ahead(server, self._query, "stop", palette.STOP, 9.0)
        self._plan = Ahead(server, self._query, "plan", palette.TOOL_PATH, 3.0)
        self._around: list[tuple[Sighting, SceneView]] = []
        self._shown: SceneView | None = None

    def show(self, moment: RecordedMoment) -> None:
        """Show a moment."""
        around = self._known(moment.sighting)
        with self.server.atomic():
            if around is not self._shown:
                if self._shown is not None:
                    self._shown.drawing.show(visible=False)
                around.drawing.show(visible=True)
                self._shown = around
            self._robot.move(self._query.kinematics(moment.positions[None]))
            clock = max(moment.time - moment.sighting.world.stamp, 0.0)
            self.nearest = around.show(clock, moment.positions)
            self._stop.show(moment.stop)
            self._plan.show(moment.plan)

    def ghosts(self, *, stop: bool, plan: bool) -> None:
        with self.server.atomic():
            self._stop.visible, self._plan.visible = stop, plan

    def _known(self, sighting: Sighting) -> SceneView:
        scene, stamp = sighting.world.scene, sighting.world.stamp
        for known, around in self._around:
            if known.world.scene is scene and known.world.stamp == stamp:
                return around
        reduced = reduce_model(scene, self._group, self._start)
        name = f"/seen_{len(self._around)}"
        around = SceneView(self.server, reduced, reduced.start_positions, root=name, robot=False)
        self._around.append((sighting, around))
        return around


class Ahead:
    """A motion that is ahead of the robot: the line that its tool will draw, and a ghost at its end."""

    def __init__(
        self, server: "ViserServer", query: Evaluator, name: str, colour: Rgb, thickness: float
    ) -> None:
        self.visible, reduced = True, query.reduced
        self._query, self._tool = query, reduced.attachment(tool_frame(reduced))
        self._ghost = Ghost(server, reduced, f"{name}_ghost", colour)
        self._trail = Trail(server, f"/{name}_path", colour, thickness)

    def show(self, motion: Trajectory | None) -> None:
        if motion is None or not self.visible:
            self._trail.show(None)
            self._ghost.stand(None)
            return
        placed = self._query.kinematics(motion(np.linspace(0.0, motion.duration, POINTS)))
        joint, held = self._tool
        self._trail.show(placed.rotation[:, joint] @ held.translation + placed.translation[:, joint])
        self._ghost.stand(placed)


EVENTS = 8
"""Number of listed events, the latest ones."""


@checked
def view_run(recording: Recording, *, port: int = 8080, host: str = "127.0.0.1") -> "RunViewer":
    """Serve a page that shows a recorded run, as `view` does."""
    first = recording.sightings[0]
    drawing = RunDrawing(open_server(host, port), recording.group, recording.start, first)
    motion = None
    if len(recording.times) > 1:
        since = recording.times - recording.begin
        motion = Trajectory(recording.joint_names, since, recording.positions)
    return RunViewer(drawing, recording, motion)


@checked
def watch_run(problem: Problem, *, port: int = 8080, host: str = "127.0.0.1") -> "RunViewer":
    """Serve a page that shows a run live, as `view` does.

    `viewer.look` receives the supervisor after each cycle: `run(problem, watch=viewer.look)`.
    """
    first = Sighting(since=-np.inf, world=WorldSnapshot(problem.scene, 0.0))
    drawing = RunDrawing(open_server(host, port), problem.group, problem.start_positions, first)
    return RunViewer(drawing, Logbook(), None)


class RunViewer(PlayedPage):
    """A page that shows a run; `watch_run` and `view_run` open one."""

    def __init__(self, drawing: RunDrawing, source: Logbook | Recording, motion: Trajectory | None) -> None:
        server = drawing.server
        super().__init__(server)
        self._drawing, self._source = drawing, source
        self._moment: RecordedMoment | None = None
        self._shown = 0
        self._kept: tuple[int, Recording] | None = None
        look_from_the_best_side(server, drawing.reduced, motion)
        gui = server.gui
        live = isinstance(source, Logbook)
        duration = 0.0 if isinstance(source, Logbook) else source.duration
        self._live = gui.add_checkbox("live", live, visible=live)
        self._playback = Playback(server, duration, self._draw, taken=self._leave_live)
        stop, plan = gui.add_checkbox("stop (orange)", True), gui.add_checkbox("plan (purple)", True)
        self._clearance_text, self._events_text = gui.add_html(""), gui.add_html("")

        @stop.on_update
        @plan.on_update
        def _(_: object) -> None:
            self._drawing.ghosts(stop=stop.value, plan=plan.value)
            self._playback.refresh(self._playback.time)

        self._playback.refresh(0.0)
        self._follower = threading.Thread(target=self._follow, name="trajopt run viewer", daemon=True)
        self._follower.start()

    @property
    def moment(self) -> RecordedMoment | None:
        """The shown moment; None before the first."""
        return self._moment

    @property
    def nearest(self) -> Nearest | None:
        """The pair with the smallest clearance at the shown time."""
        return self._drawing.nearest

    @property
    def recording(self) -> Recording:
        """The recording until now."""
        source = self._source
        if isinstance(source, Recording):
            return source
        looks = source.samples
        if self._kept is None or self._kept[0] != looks:
            self._kept = looks, source.recording
        return self._kept[1]

    @checked
    def look(self, watched: CommitLoop) -> None:
        """Record the present moment; another thread draws it soon after."""
        if isinstance(self._source, Recording):
            raise ProblemError("this page shows a recording: watch_run shows a run live")
        self._source.look(watched)

    def _end(self) -> None:
        self._follower.join()
        super()._end()

    def _leave_live(self) -> None:
        self._live.value = False

    def _follow(self) -> None:
        source = self._source
        while isinstance(source, Logbook) and not self._closed.wait(FRAME_TIME):
            looks = source.samples
            if looks == self._shown:
                continue
            self._shown = looks
            with self._playback.lock:
                self._playback.lengthen(source.duration)
                if self._live.value:
                    self._playback.show(source.duration)

    def _draw(self, t: float) -> None:
        source = self._source
        if isinstance(source, Logbook):
            if not source.samples:
                return
            live = self._live.value and t >= source.duration
            self._moment = source.moment if live else self.recording.at(self.recording.begin + t)
        else:
            self._moment = source.at(source.begin + t)
        self._drawing.show(self._moment)
        self._clearance_text.content = clearance_html(self._drawing.nearest)
        self._events_text.content = events_html(self._moment.events, EVENTS)
