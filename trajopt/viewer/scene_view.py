"""A scene in a page, at one time."""

from typing import TYPE_CHECKING

import numpy as np

from trajopt.geometry import JointPlacements
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Trajectory
from trajopt.viewer.clearance import ClearanceQuery, Nearest
from trajopt.viewer.drawing import Drawing

if TYPE_CHECKING:
    from viser import ViserServer

    from trajopt.simulation.camera import CameraView
    from trajopt.simulation.sampled_motion import SampledMotion

LONG = 1e6
"""Assumed duration without an end: a contact allowance up to it never counts [s]."""
ASPECT = 1.0
"""Width over height of the area left of the controls, which the subject fills."""


class SceneView:
    """A scene drawn in a page, at one time and in one configuration.

    Attributes:
        nearest: The pair with the smallest clearance as drawn; None before, or without pairs.
        hiding: Names of the objects that hide the motion from the chosen viewpoint.
    """

    def __init__(
        self,
        server: "ViserServer",
        reduced: ReducedModel,
        positions: Floats,
        *,
        duration: float = LONG,
        root: str = "",
        robot: bool = True,
    ) -> None:
        self._server, self._reduced = server, reduced
        self.clearance = ClearanceQuery(reduced, duration)
        self.nearest: Nearest | None = None
        self.hiding: frozenset[str] = frozenset()
        start = self.kinematics(0.0, positions)
        self.drawing = Drawing(server, self.clearance.reduced, start, root=root, robot=robot)
        if self.clearance.timed is not None:
            self.drawing.draw_halos(self.clearance.timed)

    def kinematics(self, time: float, positions: Floats) -> JointPlacements:
        at = self.clearance.positions(np.array([time]), positions[None])
        return self.clearance.query.kinematics(at)

    def show(self, time: float, positions: Floats) -> Nearest | None:
        self.nearest = self.clearance.nearest(time, positions)
        with self._server.atomic():
            self.drawing.move(self.kinematics(time, positions))
            if self.clearance.timed is not None:
                self.drawing.show_changing(self.clearance.timed, time)
            self.drawing.point_out(self.nearest)
        return self.nearest

    def look(self, motion: "SampledMotion", *, paths: bool = True, aspect: float = ASPECT) -> None:
        from trajopt.simulation.picture_model import tool_paths  # MuJoCo takes a second to import
        from trajopt.simulation.viewpoint import look_at

        if paths:
            self.drawing.draw_tool_paths(tool_paths(self._reduced, motion))
        view = look_at(self._reduced, motion, aspect)
        self.hiding = frozenset(view.hiding)
        self.drawing.make_translucent(self.hiding)
        aim(self._server, view.camera)


def look_from_the_best_side(
    server: "ViserServer",
    reduced: ReducedModel,
    motion: Trajectory | None,
    *,
    back: float = 1.0,
    aside: float = 0.0,
) -> None:
    """Choose the least obstructed view of a motion, or of the robot at rest.

    Args:
        back: Factor on the distance at which everything just fits.
        aside: Shift of the subject to the left, as a share of the picture's height.
    """
    from trajopt.simulation.sampled_motion import motion_of
    from trajopt.simulation.viewpoint import look_at

    resting = np.tile(reduced.start_positions, (2, 1))
    seen = motion or Trajectory(reduced.joint_names, np.array((0.0, 1.0)), resting)
    aim(server, look_at(reduced, motion_of(reduced, seen), ASPECT).camera, back=back, aside=aside)


def aim(server: "ViserServer", view: "CameraView", *, back: float = 1.0, aside: float = 0.0) -> None:
    from trajopt.simulation.camera import FIELD_OF_VIEW

    camera = server.initial_camera
    away = back * (view.position - view.target)
    right = np.cross(-away, (0.0, 0.0, 1.0))  # no camera looks straight down
    moved = 2.0 * np.linalg.norm(away) * np.tan(FIELD_OF_VIEW / 2.0) * aside * right / np.linalg.norm(right)
    camera.look_at, camera.position = view.target + moved, view.target + moved + away
    camera.fov = float(FIELD_OF_VIEW)
