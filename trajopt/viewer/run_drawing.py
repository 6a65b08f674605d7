"""A moment of a run in the page: the robot, its plan, its stop, and its surroundings."""

from typing import TYPE_CHECKING

import numpy as np

from trajopt.driving.recording import RecordedMoment, Sighting
from trajopt.geometry import Evaluator, evaluator
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model, tool_frame
from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Trajectory
from trajopt.viewer import palette
from trajopt.viewer.clearance import ClearanceQuery, Nearest
from trajopt.viewer.drawing import POINTS, Drawing, Ghost, Trail
from trajopt.viewer.palette import Rgb

if TYPE_CHECKING:
    from viser import ViserServer

    from trajopt.viewer.guarded_server import GuardedServer

LONG = 1e6
"""Assumed duration of a run: a contact allowance up to its end never counts [s]."""


class RunDrawing:
    """The measured robot, ghosts at its stop and goal, and the known world.

    Attributes:
        server: Serves the page.
        reduced: The robot in the first known world.
        nearest: The pair with the smallest clearance in the shown moment.
    """

    def __init__(self, server: "GuardedServer", group: str, start: Floats, first: Sighting) -> None:
        """Draw the robot at its start.

        Args:
            server: Serves the page.
            group: The group that moves.
            start: Positions of all joints at the start, shape (number of joints,) [rad | m].
            first: The world known at the start.
        """
        self.server, self._group, self._start = server, group, start
        self.reduced = reduce_model(first.world.scene, group, start)
        self.nearest: Nearest | None = None
        self._query = evaluator(self.reduced)
        here = self._query.kinematics(self.reduced.start_positions[None])
        self._robot = Drawing(server, self.reduced, here, objects=False)
        # The plan begins with the way to the stop, or nearly: that is seen on either side of it.
        self._stop = Ahead(server, self._query, "stop", palette.STOP, 9.0)
        self._plan = Ahead(server, self._query, "plan", palette.TOOL_PATH, 3.0)
        self._around: list[tuple[Sighting, Around]] = []
        self._shown: Around | None = None

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
            self.nearest = around.show(moment)
            self._stop.show(moment.stop)
            self._plan.show(moment.plan)

    def ghosts(self, *, stop: bool, plan: bool) -> None:
        """Select the shown ghosts."""
        with self.server.atomic():
            self._stop.visible, self._plan.visible = stop, plan

    def _known(self, sighting: Sighting) -> "Around":
        """Return the known surroundings; drawn on first use."""
        scene, stamp = sighting.world.scene, sighting.world.stamp
        for known, around in self._around:
            if known.world.scene is scene and known.world.stamp == stamp:
                return around
        reduced = reduce_model(scene, self._group, self._start)
        around = Around(self.server, reduced, stamp, f"/seen_{len(self._around)}")
        self._around.append((sighting, around))
        return around


class Around:
    """What is around the robot, as it was known from one time to another.

    Attributes:
        drawing: Its objects, and what is nearest to the robot.
    """

    def __init__(self, server: "ViserServer", reduced: ReducedModel, stamp: float, name: str) -> None:
        """Draw it; the clock of the scene shows 0 at the stamp [s]."""
        self._clearance, self._stamp = ClearanceQuery(reduced, LONG), stamp
        here = self._clearance.positions(np.zeros(1), reduced.start_positions[None])
        start = self._clearance.query.kinematics(here)
        self.drawing = Drawing(server, self._clearance.reduced, start, root=name, robot=False)
        if self._clearance.timed is not None:
            self.drawing.draw_halos(self._clearance.timed)

    def show(self, moment: RecordedMoment) -> Nearest | None:
        """Show it in a moment; return the nearest pair."""
        seen, time = self._clearance, max(moment.time - self._stamp, 0.0)
        at = seen.positions(np.array((time,)), moment.positions[None])
        self.drawing.move(seen.query.kinematics(at))
        if seen.timed is not None:
            self.drawing.show_changing(seen.timed, time)
        nearest = seen.nearest(time, moment.positions)
        self.drawing.point_out(nearest)
        return nearest


class Ahead:
    """A motion that is ahead of the robot: the line that its tool will draw, and a ghost at its end.

    Attributes:
        visible: Whether it is to be seen.
    """

    def __init__(
        self, server: "ViserServer", query: Evaluator, name: str, colour: Rgb, thickness: float
    ) -> None:
        """Prepare it with a line of this width on the screen [px]; nothing is shown yet."""
        self.visible, reduced = True, query.reduced
        self._query, self._tool = query, reduced.attachment(tool_frame(reduced))
        self._ghost = Ghost(server, reduced, f"{name}_ghost", colour)
        self._trail = Trail(server, f"/{name}_path", colour, thickness)

    def show(self, motion: Trajectory | None) -> None:
        """Show a motion, or none."""
        if motion is None or not self.visible:
            self._trail.show(None)
            self._ghost.stand(None)
            return
        placed = self._query.kinematics(motion(np.linspace(0.0, motion.duration, POINTS)))
        joint, held = self._tool
        self._trail.show(placed.rotation[:, joint] @ held.translation + placed.translation[:, joint])
        self._ghost.stand(placed)
