"""Cameras: the smallest distance from which a whole motion is in view, and coordinates in a picture."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Value, readonly
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD
from trajopt.values.shapes.shapes import Plane, bounding_box

FIELD_OF_VIEW = np.deg2rad(36.0)
"""Vertical field of view of the camera [rad]."""
BORDER = 1.04
"""Factor on the distance of an automatic camera."""
NEAREST = 0.05
"""Least distance of an automatic camera [m]."""
SURROUNDINGS = 0.1
"""Margin around the motion in which objects are in view, as a share of its size."""


@checked
@dataclass(frozen=True, eq=False)
class CameraView(Value):
    """A camera that looks at a point.

    Attributes:
        target: The point it looks at, shape (3,) in the world [m].
        distance: From the camera to the point [m].
        azimuth: Viewing direction, about z from x [rad].
        elevation: Viewing direction above the horizon [rad]; negative looks down.
    """

    target: Floats
    distance: float
    azimuth: float
    elevation: float

    @property
    def position(self) -> Floats:
        """Its position, shape (3,) in the world [m]."""
        return self.target - self.distance * _axes(self.azimuth, self.elevation)[0]


def frame_points(points: Floats, azimuth: float, elevation: float, aspect: float) -> CameraView:
    """Return the nearest camera with a viewing direction [rad] that has all points (k, 3) in view."""
    axes = _axes(azimuth, elevation)
    target = (points.min(axis=0) + points.max(axis=0)) / 2
    slope = np.tan(FIELD_OF_VIEW / 2) * np.array((aspect, 1.0))
    distance = 1.0
    for _ in range(8):
        depth, across = _project(points - target, axes)
        distance = max(float((np.abs(across) / slope - depth[:, None]).max()), NEAREST)
        # Shift the target to the middle of the picture, and repeat.
        drawn = across / (distance + depth)[:, None]
        middle = (drawn.min(axis=0) + drawn.max(axis=0)) / 2 * distance
        target = target + middle @ axes[1:]
    return CameraView(readonly(target), distance * BORDER, azimuth, elevation)


def picture_coordinates(view: CameraView, points: Floats) -> Floats:
    depth, across = _project(points - view.target, _axes(view.azimuth, view.elevation))
    return across / np.maximum(view.distance + depth, NEAREST)[:, None]


def visible_points(
    reduced: ReducedModel,
    configurations: Floats,
    *,
    times: Floats | None = None,
    always: Collection[str] = (),
) -> Floats:
    """Return corners, shape (m, 3) in the world [m], of the moving robot and the objects close to it.

    Objects are clipped to the box around the motion and its margin; half-spaces do not count.

    Args:
        configurations: Of the group along the motion, shape (k, n) [rad | m].
        always: Objects that must be entirely in view, at any place.
    """
    from trajopt.simulation.dynamic_scene import DynamicScene  # importing MuJoCo takes a second

    scene, changing = reduced.scene, DynamicScene.of(reduced)
    shown = [b for b in (*scene.robot.bodies, *scene.object_bodies()) if not isinstance(b.shape, Plane)]
    moved: list[Floats] = []
    still: list[Floats] = []
    moments = np.zeros(len(configurations)) if times is None else times
    for count, (positions, time) in enumerate(zip(configurations, moments.tolist(), strict=True)):
        place = reduced.all_positions(positions)
        frames = {body.frame: scene.placement_of(body.frame, place) for body in shown}
        moved.append(np.array([scene.placement_of(link, place).translation for link in scene.robot.links]))
        for body in shown:
            if not changing.present(body.owner, time):
                continue
            points = frames[body.frame] * (body.placement * _corners(*bounding_box(body.shape)))
            points = changing.moved(body.owner, time) * points
            if body.frame != WORLD or body.owner in always:
                moved.append(points)
            elif count == 0 or body.owner in changing.timings:
                still.append(points)
    cloud = np.concatenate(moved)
    low, high = cloud.min(axis=0), cloud.max(axis=0)
    around = SURROUNDINGS * float(np.linalg.norm(high - low))
    for points in still:
        lower = np.maximum(points.min(axis=0), low - around)
        upper = np.minimum(points.max(axis=0), high + around)
        if (lower <= upper).all():
            cloud = np.vstack((cloud, _corners(lower, upper)))
    return cloud


def _corners(lower: Floats, upper: Floats) -> Floats:
    choice = np.indices((2, 2, 2)).reshape(3, 8).T
    return np.where(choice, upper, lower)


def _axes(azimuth: float, elevation: float) -> Floats:
    level, rise = np.cos(elevation), np.sin(elevation)
    along, aside = np.cos(azimuth), np.sin(azimuth)
    return np.array(
        (
            (level * along, level * aside, rise),
            (aside, -along, 0.0),
            (-rise * along, -rise * aside, level),
        )
    )


def _project(offsets: Floats, axes: Floats) -> tuple[Floats, Floats]:
    local = offsets @ axes.T
    return local[:, 0], local[:, 1:]
