"""The live page, alone or for a session of `trajopt serve`."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import numpy as np

from trajopt.robot.configuration import ConfigurationLike
from trajopt.scene.scene import Scene
from trajopt.server.operation import Answer, Lane, Operation, SessionState, Watch
from trajopt.values.arrays import Floats, Value, one_of
from trajopt.values.documents.document import Node
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked, checked_class
from trajopt.values.placement import Placement
from trajopt.values.trajectory import Trajectory
from trajopt.viewer import palette
from trajopt.viewer.clearance import Nearest
from trajopt.viewer.drawing import POINTS, Trail
from trajopt.viewer.live.background import PlanningOutcome, Reach, Reaching
from trajopt.viewer.live.handles import COLOURS, EditedScene, GoalDrawing
from trajopt.viewer.live.objects import ObjectsPanel
from trajopt.viewer.live.panels import Desk, DrivePanel, GoalPanel, MotionPanel
from trajopt.viewer.live.workbench import Goal, Workbench
from trajopt.viewer.readout import block_html
from trajopt.viewer.scene_view import look_from_the_best_side
from trajopt.viewer.server import Served, open_server

if TYPE_CHECKING:
    from viser import ViserServer

    from trajopt.viewer.guarded_server import GuardedServer


@dataclass(frozen=True)
class Shown(Value):
    """The drawn items."""

    links: bool = True
    collision: bool = False
    trail: bool = True
    nearest: bool = True
    reach: bool = False


WORDS = {
    "links": ("robot as it looks", "The robot's visual shapes."),
    "collision": ("collision shapes", "The shapes that count when clearances are measured."),
    "trail": ("trail of the hand", "The line that the hand draws along the planned motion."),
    "nearest": ("nearest pairs", "The nearest pairs, with their distances."),
    "reach": ("reach of the hand", "The collision-free reach of the hand; takes a moment."),
}


class ShownPanel:
    """Controls of the drawn items."""

    def __init__(self, server: "ViserServer", changed: Callable[[Shown], None]) -> None:
        plain = Shown()
        self._ticks = {
            name: server.gui.add_checkbox(label, getattr(plain, name), hint=hint)
            for name, (label, hint) in WORDS.items()
        }
        for tick in self._ticks.values():
            tick.on_update(lambda _: changed(self.shown))
        self._text = server.gui.add_html("")

    def say(self, words: str) -> None:
        self._text.content = block_html("", [words]) if words else ""

    @property
    def shown(self) -> Shown:
        return Shown(**{name: tick.value for name, tick in self._ticks.items()})


DOT = 0.005
"""Size of the dots of the reach [m]."""


class Picture:
    """All that is drawn."""

    def __init__(
        self,
        server: "ViserServer",
        bench: Workbench,
        *,
        dragged: "Callable[[Placement], None]",
        picked: "Callable[[str], None]",
        displaced: "Callable[[Placement], None]",
    ) -> None:
        self._server, self._bench = server, bench
        self.positions, self._shown = bench.positions, Shown()
        self._scene = EditedScene(server, bench.reduced, self.positions, picked, displaced)
        self._goal = GoalDrawing(server, bench.reduced, dragged)
        self._trail = Trail(server, "/trail", palette.TOOL_PATH, 3.0)
        self._motion: Trajectory | None = None
        self._reach = server.scene.add_point_cloud(
            "/reach", np.zeros((1, 3)), (0, 0, 0), point_size=DOT, point_shape="circle", visible=False
        )
        self.show_goal()
        self.stand(self.positions)

    @property
    def nearest(self) -> tuple[Nearest, ...]:
        return self._scene.nearest

    def stand(self, positions: Floats) -> None:
        self.positions = positions
        self._scene.show(positions, pairs=self._shown.nearest)

    def renew(self) -> None:
        self._scene.change(self._bench.reduced, self.positions)
        self._goal.renew(self._bench.reduced)
        self.show_goal()
        self.stand(self.positions)

    def choose(self, name: str) -> None:
        self._scene.choose(name)
        self.stand(self.positions)

    def show_goal(self) -> None:
        self._goal.show(self._bench.goal, self._scene.clearance.query, self._bench.positions)

    def show_motion(self, motion: Trajectory | None) -> None:
        self._motion = motion
        if motion is None or not self._shown.trail:
            self._trail.show(None)
            return
        placed = self._scene.kinematics(motion(np.linspace(0.0, motion.duration, POINTS)))
        self._trail.show(self._scene.line_of(self._bench.hand, placed))

    def show_reach(self, reach: Reach | None) -> None:
        self._reach.visible = reach is not None
        if reach is not None:
            self._reach.points, self._reach.colors = reach.points.astype(np.float16), reach.colours

    def switch(self, shown: Shown) -> None:
        self._shown = shown
        with self._server.atomic():
            self._scene.robot.show_visual_shapes(shown.links)
            self._scene.robot.show_collision_shapes(shown.collision)
            self.show_motion(self._motion)
            self.stand(self.positions)


BACK, ASIDE = 1.35, 0.16
"""Factor on the camera distance, and shift to the left, as a share of the page's height, away from the
controls.
"""


@checked
def live_view(
    scene: Scene,
    *,
    group: str = "",
    start: ConfigurationLike | None = None,
    port: int = 8080,
    host: str = "127.0.0.1",
) -> "LiveView":
    """Serve a page for planning by hand, as `view` does.

    Args:
        group: The group that moves; if empty the only one, or the first that ends in a hand.
        start: Configuration of the robot; by default each group in its first named state.

    Raises:
        GroupNotFound: If there is no such group.
        ProblemError: If the port cannot be opened on this host, or an object moves by itself.
    """
    bench = Workbench(_still(scene), group, start)
    return LiveView(open_server(host, port), bench)


def _still(scene: Scene) -> Scene:
    if one_of("scene", scene, Scene).changing:
        raise ProblemError(
            "live_view: things in the scene move by themselves; show it with view or watch_run"
        )
    return scene


@checked_class
class LiveView(Served):
    """A page for planning by hand; `live_view` opens one."""

    def __init__(self, server: "GuardedServer", bench: Workbench) -> None:
        super().__init__(server)
        self._bench, self._desk = bench, Desk(self._say)
        self._reaching: Reaching | None = None
        look_from_the_best_side(server, bench.reduced, None, back=BACK, aside=ASIDE)
        self._picture = Picture(
            server,
            bench,
            dragged=self._drag,
            picked=self._pick,
            displaced=self._displace,
        )
        self._goal_text = server.gui.add_html("")
        self._motion = MotionPanel(
            server,
            self._desk,
            bench,
            stand=self._picture.stand,
            show_motion=self._picture.show_motion,
            found=self._motion_changed,
        )
        self._drive = DrivePanel(
            server, self._desk, bench, stand=self._picture.stand, changed=self._robot_changed
        )
        tabs = server.gui.add_tab_group()
        with tabs.add_tab("Goal"):
            self._goal = GoalPanel(server, bench, self._ask_goal)
        with tabs.add_tab("Objects"):
            self._objects = ObjectsPanel(server, bench, self._ask_around, self._picture.choose)
        with tabs.add_tab("Show"):
            self._shown = ShownPanel(server, self._ask_shown)
        self._show_goal()

    @property
    def goal(self) -> Goal:
        """The goal of the robot."""
        return self._bench.goal

    @property
    def planned(self) -> PlanningOutcome | None:
        return self._motion.planned

    @property
    def time(self) -> float:
        """Shown time of the motion [s]."""
        return self._motion.playback.time

    @property
    def positions(self) -> Floats:
        return self._picture.positions

    @property
    def robot_positions(self) -> Floats:
        """Present positions of all joints, shape (number of joints,) [rad | m]."""
        driving = self._drive.driving
        now = driving.positions if driving is not None and driving.busy else self._bench.positions
        return self._bench.reduced.all_positions(now)

    @property
    def group(self) -> str:
        """The group that moves."""
        return self._bench.group

    def see(self, scene: Scene) -> None:
        seen = _still(scene)
        self._ask_around("seen", lambda: self._bench.change(seen))

    def settle(self, seconds: float = 60.0) -> bool:
        """Wait until all requests except planning are handled; return False after a time-out."""
        return self._desk.settle(seconds)

    def _end(self) -> None:
        self._drive.close()
        self._motion.close()
        if self._reaching is not None:
            self._reaching.close()
        self._desk.close()

    def _drag(self, placement: Placement) -> None:
        self._ask_goal("goal", lambda: self._bench.move_hand(placement))

    def _displace(self, placement: Placement) -> None:
        self._objects.move(placement)

    def _pick(self, name: str) -> None:
        self._ask_around("choose", lambda: self._objects.choose(name))

    def _ask_goal(self, name: str, change: Callable[[], None]) -> None:
        self._desk.do(name, lambda: self._change_goal(change))

    def _ask_around(self, name: str, change: Callable[[], None]) -> None:
        def edit() -> None:
            before = self._bench.scene
            change()
            if self._bench.scene is not before:
                self._motion.drop()
                self._drive.see()
                self._picture.renew()
                self._find_reach()
                self._show_goal()
            self._objects.show()
            self._picture.choose(self._objects.chosen)

        self._desk.do(name, edit)

    def _change_goal(self, change: Callable[[], None]) -> None:
        change()
        self._motion.drop()
        self._show_goal()

    def _motion_changed(self) -> None:
        motion = self._motion.motion
        if motion is not None:
            self._bench.take_posture(motion(motion.duration))
        self._show_goal()

    def _ask_shown(self, shown: Shown) -> None:
        def switch() -> None:
            self._picture.switch(shown)
            self._find_reach()

        self._desk.do("shown", switch)

    def _find_reach(self) -> None:
        self._picture.show_reach(None)
        asked = self._shown.shown.reach
        self._shown.say("Sampling the reach of the hand ..." if asked else "")
        if asked and self._reaching is None:
            self._reaching = Reaching(self._bench.reduced, self._bench.hand, self._reached)

    def _reached(self, reaching: Reaching, found: Reach | str) -> None:
        def show() -> None:
            self._reaching = None
            if reaching.reduced is not self._bench.reduced:
                self._find_reach()  # something has changed since
            elif self._shown.shown.reach:
                self._picture.show_reach(None if isinstance(found, str) else found)
                self._shown.say(found if isinstance(found, str) else found.words)

        self._desk.do("reach", show)

    def _robot_changed(self) -> None:
        if not self._drive.busy:
            self._motion.drop()
            self._picture.stand(self._bench.positions)
            self._picture.renew()
        self._show_goal()

    def _show_goal(self) -> None:
        goal = self._bench.goal
        self._picture.show_goal()
        self._goal.show()
        there = self._bench.at_goal
        title = "The goal is the present configuration" if there else f"The goal is {goal.reachability.value}"
        self._goal_text.content = block_html(title, [goal.words], COLOURS[goal.reachability])
        self._motion.show()
        self._drive.show(planned=self._motion.motion is not None)

    def _say(self, refusal: str) -> None:
        self._motion.say("That could not be done", [refusal])


PERIOD = 0.1
"""Time from one look at the session to the next [s]."""


def page(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Serve the live page of a session until the request is cancelled.

    The first feedback has `port` and `path` of the page, and its `group`. The session's robot follows the
    page's.
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
