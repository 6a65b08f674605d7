"""The picture of the live page: the robot at a posture, what is around it, its goal and what is near."""

from typing import TYPE_CHECKING

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.placement import Placement
from trajopt.model.trajectory import Trajectory
from trajopt.view import palette
from trajopt.view.clearance import ClearanceQuery, Nearest
from trajopt.view.drawing import Drawing, in_world
from trajopt.view.live.goal_drawing import GoalDrawing
from trajopt.view.live.nearest_drawing import PAIRS, NearestDrawing
from trajopt.view.live.objects_drawing import ObjectsDrawing
from trajopt.view.live.shown_panel import Shown
from trajopt.view.live.workbench import Workbench
from trajopt.view.trail import POINTS, Trail

if TYPE_CHECKING:
    from collections.abc import Callable

    from viser import ViserServer

MEASURED = 24
"""Pairs that are measured to find those with something around the robot among them."""
CLOSE = 0.03
"""Of two links that are no nearer nobody asks the distance [m]."""
LONG = 1e6
"""Of a posture nobody knows how long it takes: allowances of contact before its end never count [s]."""


class Picture:
    """All that is drawn.

    Attributes:
        nearest: The nearest pairs as they are drawn, the nearest first.
        positions: Of the group as it is drawn, shape (n,) [rad | m].
    """

    def __init__(
        self,
        server: "ViserServer",
        bench: Workbench,
        *,
        dragged: "Callable[[Placement], None]",
        picked: "Callable[[str], None]",
    ) -> None:
        """Draw the robot as it stands.

        Args:
            server: Serves the page.
            bench: What is drawn.
            dragged: Told where the hand is dragged to.
            picked: Told which object is clicked.
        """
        self._server, self._bench = server, bench
        self._clearance = ClearanceQuery(bench.reduced, LONG)
        self.positions, self.nearest = bench.positions, tuple[Nearest, ...]()
        self._shown = Shown()
        here = self._clearance.query.kinematics(self.positions[None])
        self._robot = Drawing(server, bench.reduced, here, objects=False)
        self._goal = GoalDrawing(server, bench.reduced, dragged)
        self._objects = ObjectsDrawing(server, picked)
        self._objects.show(bench.reduced, here)
        self._near = NearestDrawing(server)
        self._trail = Trail(server, "/trail", palette.TOOL_PATH, 3.0)
        self._motion: Trajectory | None = None
        self.show_goal()
        self.stand(self.positions)

    def stand(self, positions: Floats) -> None:
        """Draw the robot at a posture, shape (n,) [rad | m]."""
        self.positions = positions
        here = self._clearance.query.kinematics(positions[None])
        self.nearest = near = self._near_at(positions) if self._shown.nearest else ()
        with self._server.atomic():
            self._robot.move(here)
            self._objects.move(self._bench.reduced, here)
            self._near.show(near)

    def _near_at(self, positions: Floats) -> tuple[Nearest, ...]:
        """Return the nearest pairs, of links and links only those that are close."""
        found, objects = self._clearance.nearest_pairs(0.0, positions, MEASURED), self._bench.scene.objects
        apart = [
            each for each in found if each.distance < CLOSE or not objects.keys().isdisjoint(each.owners)
        ]
        return tuple((apart or found)[:PAIRS])

    def renew(self) -> None:
        """Draw what is around the robot anew: it has changed, or the robot stands elsewhere."""
        self._clearance = ClearanceQuery(self._bench.reduced, LONG)
        self._objects.show(self._bench.reduced, self._clearance.query.kinematics(self.positions[None]))
        self._goal.renew(self._bench.reduced)
        self.show_goal()
        self.stand(self.positions)

    def show_goal(self) -> None:
        """Draw the goal as it is."""
        self._goal.show(self._bench.goal, self._clearance.query, self._bench.positions)

    def show_motion(self, motion: Trajectory | None) -> None:
        """Draw the line of the hand along a motion, or none."""
        self._motion = motion
        if motion is None or not self._shown.trail:
            self._trail.show(None)
            return
        placed = self._clearance.query.kinematics(motion(np.linspace(0.0, motion.duration, POINTS)))
        joint, held = self._bench.reduced.attachment(self._bench.hand)
        self._trail.show(placed.rotation[:, joint] @ held.translation + placed.translation[:, joint])

    def switch(self, shown: Shown) -> None:
        """Draw some of it, and some not."""
        self._shown = shown
        with self._server.atomic():
            self._robot.show_visual_shapes(shown.links)
            self._robot.show_collision_shapes(shown.collision)
            self.show_motion(self._motion)
            self.stand(self.positions)

    def hand_drawn(self) -> Placement:
        """Return where the hand is drawn, in the world."""
        here = self._clearance.query.kinematics(self.positions[None])
        return in_world(self._bench.reduced, self._bench.hand, here)
