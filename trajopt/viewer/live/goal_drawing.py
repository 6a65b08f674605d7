"""The goal in the page: arrows and rings at the hand for dragging, and the robot in the goal posture."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from trajopt.geometry import Evaluator
from trajopt.scene.reduced import ReducedModel
from trajopt.values.placement import Placement
from trajopt.viewer import palette
from trajopt.viewer.drawing import Ghost
from trajopt.viewer.live.gizmo import Gizmo
from trajopt.viewer.live.goal import Goal, Reachability
from trajopt.viewer.palette import Rgb

if TYPE_CHECKING:
    from viser import ViserServer

GIZMO = 0.22
"""Length of the arrows [m], about that of a hand."""
OPACITY = 0.45
"""Of the robot at its goal: its colour is to be read at a glance, the robot to be seen through it."""
SAME = 5e-3
"""A robot with each joint so near to its goal hides it: it is drawn once [rad | m]."""

COLOURS: dict[Reachability, Rgb] = {
    Reachability.REACHABLE: (0x22, 0x99, 0x66),
    Reachability.COLLIDING: palette.TOUCHING,
    Reachability.BEYOND_LIMITS: palette.STOP,
    Reachability.OUT_OF_REACH: (0x88, 0x88, 0x88),
}
"""Of the robot at its goal."""


class GoalDrawing:
    """The drawn goal and its gizmo."""

    def __init__(
        self, server: "ViserServer", reduced: ReducedModel, dragged: Callable[[Placement], None]
    ) -> None:
        """Prepare it; nothing is shown yet.

        Args:
            server: Serves the page.
            reduced: The robot with its attached objects.
            dragged: Receives the dragged placement of the hand in the world.
        """
        self._server, self._ghosts = server, 0
        self.gizmo = Gizmo(server, "/goal/hand", GIZMO, dragged)
        self._ghost = Ghost(server, reduced, "goal_0", COLOURS[Reachability.REACHABLE], opacity=OPACITY)
        self._carried = _moved(reduced)

    def renew(self, reduced: ReducedModel) -> None:
        """Draw the robot again if its attached objects changed."""
        carried = _moved(reduced)
        if carried == self._carried:
            return
        self._carried = carried
        self._ghost.remove()
        self._ghosts += 1
        self._ghost = Ghost(
            self._server, reduced, f"goal_{self._ghosts}", COLOURS[Reachability.REACHABLE], opacity=OPACITY
        )

    def show(self, goal: Goal, query: Evaluator, now: np.ndarray) -> None:
        """Show a goal.

        Args:
            goal: The goal.
            query: Of the drawn robot.
            now: Drawn positions of the robot, shape (n,) [rad | m].
        """
        with self._server.atomic():
            self.gizmo.show(goal.placement)
            elsewhere = float(np.abs(goal.positions - now).max()) > SAME
            self._ghost.paint(COLOURS[goal.reachability])
            self._ghost.stand(query.kinematics(goal.positions[None]) if elsewhere else None)


def _moved(reduced: ReducedModel) -> list[tuple[str, int, bytes]]:
    """Return a key of the bodies that the group moves."""
    return [
        (body.name, id(body.shape), body.placement.homogeneous.tobytes())
        for body in reduced.bodies
        if body.joint
    ]
