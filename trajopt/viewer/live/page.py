"""The live page: drag the hand, plan, look at the motion."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from trajopt.robot.configuration import ConfigurationLike
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, one_of
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement
from trajopt.viewer.live.background import PlanningOutcome, Reach, Reaching
from trajopt.viewer.live.handles import COLOURS
from trajopt.viewer.live.objects import ObjectsPanel
from trajopt.viewer.live.panels import Desk, DrivePanel, GoalPanel, MotionPanel
from trajopt.viewer.live.picture import Picture, Shown, ShownPanel
from trajopt.viewer.live.workbench import Goal, Workbench
from trajopt.viewer.readout import block_html
from trajopt.viewer.scene_view import look_from_the_best_side
from trajopt.viewer.server import Served, open_server

if TYPE_CHECKING:
    from trajopt.viewer.guarded_server import GuardedServer

BACK, ASIDE = 1.35, 0.16
"""Factor on the camera distance, since the hand will move elsewhere, and shift to the left, as a share of the
page's height, away from the controls.
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
    """Serve a page for planning by hand; returns immediately.

    Args:
        scene: The robot and its surroundings.
        group: The group that moves; if empty the only one, or the first that ends in a hand.
        start: Configuration of the robot; by default each group in its first named state.
        port: Port to serve on; the next free one if it is taken.
        host: Address to serve on; "0.0.0.0" lets other machines use the page too.

    Returns:
        The page: open its `url` in a browser; `wait()` keeps a script alive.

    Raises:
        MissingExtra: If viser is not installed.
        GroupNotFound: If there is no such group.
        ProblemError: If the port cannot be opened on this host, or an object moves by itself.
    """
    bench = Workbench(_still(scene), group, start)
    return LiveView(open_server(host, port), bench)


def _still(scene: Scene) -> Scene:
    """Return a scene in which nothing moves by itself.

    Raises:
        ProblemError: If something does.
    """
    if one_of("scene", scene, Scene).changing:
        raise ProblemError(
            "live_view: things in the scene move by themselves; show it with view or watch_run"
        )
    return scene


class LiveView(Served):
    """A page for planning by hand; `live_view` opens one.

    Attributes:
        url: Address of the page.
    """

    def __init__(self, server: "GuardedServer", bench: Workbench) -> None:
        """Draw the robot and the controls."""
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
        """How planning to this goal ended; None before."""
        return self._motion.planned

    @property
    def time(self) -> float:
        """Shown time of the motion [s]."""
        return self._motion.playback.time

    @property
    def positions(self) -> Floats:
        """Positions of the group's joints as they are drawn, shape (n,) [rad | m]."""
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

    @checked
    def see(self, scene: Scene) -> None:
        """Show another scene of the same robot from now on; a robot that is being driven is in it.

        Raises:
            ProblemError: If something in it moves by itself.
        """
        seen = _still(scene)
        self._ask_around("seen", lambda: self._bench.change(seen))

    @checked
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
        """Queue a change of the goal; it replaces a waiting one of that name."""
        self._desk.do(name, lambda: self._change_goal(change))

    def _ask_around(self, name: str, change: Callable[[], None]) -> None:
        """Queue a change of the objects; it replaces a waiting one of that name."""

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
        """Change the goal, and drop the motion to the previous one."""
        change()
        self._motion.drop()
        self._show_goal()

    def _motion_changed(self) -> None:
        """Show the goal in the posture in which a motion ends: the planner chooses the best that it finds."""
        motion = self._motion.motion
        if motion is not None:
            self._bench.take_posture(motion(motion.duration))
        self._show_goal()

    def _ask_shown(self, shown: Shown) -> None:
        """Show or hide an item."""

        def switch() -> None:
            self._picture.switch(shown)
            self._find_reach()

        self._desk.do("shown", switch)

    def _find_reach(self) -> None:
        """Start to compute the reach of the hand, if requested; hide the previous one."""
        self._picture.show_reach(None)
        asked = self._shown.shown.reach
        self._shown.say("Looking where the hand gets to ..." if asked else "")
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
        """Show that the robot is being driven, or rests again."""
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
        title = "The goal is where the robot is" if there else f"The goal is {goal.reachability.value}"
        self._goal_text.content = block_html(title, [goal.words], COLOURS[goal.reachability])
        self._motion.show()
        self._drive.show(planned=self._motion.motion is not None)

    def _say(self, refusal: str) -> None:
        """Show the reason why a request failed."""
        self._motion.say("That could not be done", [refusal])
