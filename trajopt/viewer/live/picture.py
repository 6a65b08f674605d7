"""The picture of the live page: robot, objects, goal, nearest pairs and reach."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from trajopt.values.arrays import Floats, Value
from trajopt.values.placement import Placement
from trajopt.values.trajectory import Trajectory
from trajopt.viewer import palette
from trajopt.viewer.clearance import Nearest
from trajopt.viewer.drawing import POINTS, Trail
from trajopt.viewer.live.background import Reach
from trajopt.viewer.live.handles import EditedScene, GoalDrawing
from trajopt.viewer.live.workbench import Workbench
from trajopt.viewer.readout import block_html

if TYPE_CHECKING:
    from viser import ViserServer


@dataclass(frozen=True)
class Shown(Value):
    """The drawn items.

    Attributes:
        links: The robot by its visual shapes.
        collision: The robot's collision shapes.
        trail: The path of the hand along the motion.
        nearest: The nearest pairs, with their distances.
        reach: The reach of the hand.
    """

    links: bool = True
    collision: bool = False
    trail: bool = True
    nearest: bool = True
    reach: bool = False


WORDS = {
    "links": ("robot as it looks", "The robot's visual shapes."),
    "collision": ("collision shapes", "The shapes that count when clearances are measured."),
    "trail": ("trail of the hand", "The line that the hand draws along the planned motion."),
    "nearest": ("nearest pairs", "What is nearest to what, with the distance."),
    "reach": ("reach of the hand", "Where the hand gets to without a collision; takes a moment."),
}
"""A label and a hint for each."""


class ShownPanel:
    """A tick for each."""

    def __init__(self, server: "ViserServer", changed: Callable[[Shown], None]) -> None:
        """Add the controls.

        Args:
            server: Serves the page.
            changed: Receives the items to draw.
        """
        plain = Shown()
        self._ticks = {
            name: server.gui.add_checkbox(label, getattr(plain, name), hint=hint)
            for name, (label, hint) in WORDS.items()
        }
        for tick in self._ticks.values():
            tick.on_update(lambda _: changed(self.shown))
        self._text = server.gui.add_html("")

    def say(self, words: str) -> None:
        """Show a text below the check boxes."""
        self._text.content = block_html("", [words]) if words else ""

    @property
    def shown(self) -> Shown:
        """The items to draw."""
        return Shown(**{name: tick.value for name, tick in self._ticks.items()})


DOT = 0.005
"""Size of the dots of the reach [m]: apart, so that the robot is seen between them."""


class Picture:
    """All that is drawn.

    Attributes:
        positions: Of the group as it is drawn, shape (n,) [rad | m].
    """

    def __init__(
        self,
        server: "ViserServer",
        bench: Workbench,
        *,
        dragged: "Callable[[Placement], None]",
        picked: "Callable[[str], None]",
        displaced: "Callable[[Placement], None]",
    ) -> None:
        """Draw the robot in its present posture.

        Args:
            server: Serves the page.
            bench: The state of the page.
            dragged: Receives the dragged placement of the hand.
            picked: Receives the clicked object.
            displaced: Receives the dragged placement of the chosen object.
        """
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
        """The nearest pairs as they are drawn, the nearest first."""
        return self._scene.nearest

    def stand(self, positions: Floats) -> None:
        """Draw the robot at a posture, shape (n,) [rad | m]."""
        self.positions = positions
        self._scene.show(positions, pairs=self._shown.nearest)

    def renew(self) -> None:
        """Draw the surroundings again after a change of them or of the robot's posture."""
        self._scene.change(self._bench.reduced, self.positions)
        self._goal.renew(self._bench.reduced)
        self.show_goal()
        self.stand(self.positions)

    def choose(self, name: str) -> None:
        """Choose an object for dragging, or none."""
        self._scene.choose(name)
        self.stand(self.positions)

    def show_goal(self) -> None:
        """Draw the goal as it is."""
        self._goal.show(self._bench.goal, self._scene.clearance.query, self._bench.positions)

    def show_motion(self, motion: Trajectory | None) -> None:
        """Draw the line of the hand along a motion, or none."""
        self._motion = motion
        if motion is None or not self._shown.trail:
            self._trail.show(None)
            return
        placed = self._scene.kinematics(motion(np.linspace(0.0, motion.duration, POINTS)))
        self._trail.show(self._scene.line_of(self._bench.hand, placed))

    def show_reach(self, reach: Reach | None) -> None:
        """Draw or hide the reach of the hand."""
        self._reach.visible = reach is not None
        if reach is not None:
            self._reach.points, self._reach.colors = reach.points.astype(np.float16), reach.colours

    def switch(self, shown: Shown) -> None:
        """Show and hide items."""
        self._shown = shown
        with self._server.atomic():
            self._scene.robot.show_visual_shapes(shown.links)
            self._scene.robot.show_collision_shapes(shown.collision)
            self.show_motion(self._motion)
            self.stand(self.positions)
