"""The page: a robot, its surroundings and a motion, with a time slider, served on a local port."""

from typing import TYPE_CHECKING, overload

import numpy as np

from trajopt.scene.planned_robot import Planned, model_and_trajectory
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats
from trajopt.values.errors import ShapeError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement
from trajopt.values.trajectory import Trajectory
from trajopt.viewer.clearance import Nearest
from trajopt.viewer.playback import Playback, PlayedPage
from trajopt.viewer.readout import clearance_html, joints_html
from trajopt.viewer.scene_view import SceneView
from trajopt.viewer.server import open_server

if TYPE_CHECKING:
    from trajopt.viewer.guarded_server import GuardedServer


@overload
def view(motion: Planned[ReducedModel], *, port: int = 8080, host: str = "127.0.0.1") -> "Viewer": ...
@overload
def view(
    motion: ReducedModel, trajectory: Trajectory, *, port: int = 8080, host: str = "127.0.0.1"
) -> "Viewer": ...
def view(
    motion: Planned[ReducedModel] | ReducedModel,
    trajectory: Trajectory | None = None,
    *,
    port: int = 8080,
    host: str = "127.0.0.1",
) -> "Viewer":
    """Serve a page that shows a plan, or any trajectory of a reduced model; returns immediately.

    Args:
        motion: A plan, or a result that has one; or the reduced model (robot and scene) of a trajectory.
        trajectory: The motion of the group's joints; the plan's own if None.
        port: Port to serve on; the next free one if it is taken.
        host: Address to serve on; "0.0.0.0" lets other machines view the page too.

    Returns:
        The viewer: open its `url` in a browser; `wait()` keeps a script alive.

    Raises:
        MissingExtra: If viser is not installed.
        PlanningFailed: If the result has no plan.
        ProblemError: If the port cannot be opened on this host.
        ShapeError: If the trajectory moves other joints than the group's.
    """
    reduced, trajectory = model_and_trajectory("view", motion, trajectory, ReducedModel)
    if trajectory.joint_names != reduced.joint_names:
        raise ShapeError("trajectory", f"moves {trajectory.joint_names}, the group is {reduced.joint_names}")
    return Viewer(open_server(host, port), reduced, trajectory)


class Viewer(PlayedPage):
    """A page that shows a motion; `view` opens one.

    Attributes:
        url: Address of the page.
    """

    def __init__(self, server: "GuardedServer", reduced: ReducedModel, trajectory: Trajectory) -> None:
        """Draw the scene and the controls, and show the beginning."""
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
        """Shown positions of the group's joints, shape (n,) [rad | m]."""
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
