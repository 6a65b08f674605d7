"""The camera's position: chosen so that the robot, the objects and the motion are in view."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats, Value, readonly
from trajopt.model.reduced import ReducedModel
from trajopt.model.requirements import WORLD
from trajopt.model.shapes import Plane, bounding_box

FIELD_OF_VIEW = np.deg2rad(36.0)
"""Vertical opening of the camera [rad]."""
ELEVATION = np.deg2rad(-20.0)
"""From where an automatic camera looks: down by this angle [rad]."""
BORDER = 1.04
"""An automatic camera is this much farther away than it must be."""
NEAREST = 0.05
"""How near an automatic camera may be to what it looks at [m]."""
SURROUNDINGS = 0.25
"""Objects farther from the robot than this share of its size need not be in view."""
CANDIDATES = np.deg2rad((140.0, 220.0, 115.0, 245.0, 160.0, 200.0, 40.0, -40.0))
"""Directions an automatic camera looks along, about z [rad]; earlier ones win ties."""


@dataclass(frozen=True, eq=False)
class CameraView(Value):
    """A camera that looks at a point.

    Attributes:
        target: The point it looks at, shape (3,) in the world [m].
        distance: From the camera to the point [m].
        azimuth: Direction it looks along, about z from x [rad].
        elevation: Of that direction above the horizon [rad]; negative looks down.
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
    """Return the nearest camera of a direction that has all points in view.

    Args:
        points: In the world, shape (k, 3) [m].
        azimuth: Direction it looks along, about z from x [rad].
        elevation: Of that direction above the horizon [rad].
        aspect: Width of the picture over its height.
    """
    axes = _axes(azimuth, elevation)
    target = (points.min(axis=0) + points.max(axis=0)) / 2
    slope = np.tan(FIELD_OF_VIEW / 2) * np.array((aspect, 1.0))
    distance = 1.0
    for _ in range(8):
        depth, across = _project(points - target, axes)
        distance = max(float((np.abs(across) / slope - depth[:, None]).max()), NEAREST)
        # Shift the target to the middle of what is seen, and look again.
        seen = across / (distance + depth)[:, None]
        middle = (seen.min(axis=0) + seen.max(axis=0)) / 2 * distance
        target = target + middle @ axes[1:]
    return CameraView(readonly(target), distance * BORDER, azimuth, elevation)


def automatic_view(
    points: Floats, path: Floats, aspect: float, share_seen: Callable[[Floats], float]
) -> CameraView:
    """Choose the direction from which the tool is hidden least, and moves across most.

    Args:
        points: What must be in view, shape (m, 3) in the world [m].
        path: Where the tool is during the motion, shape (k, 3) [m].
        aspect: Width of the picture over its height.
        share_seen: For a position of the camera, the share of the motion during which the tool is seen.
    """
    best, best_score = None, -np.inf
    for rank, azimuth in enumerate(CANDIDATES):
        view = frame_points(points, float(azimuth), float(ELEVATION), aspect)
        across = _project(path - view.target, _axes(view.azimuth, view.elevation))[1]
        extent = float(np.linalg.norm(np.ptp(across, axis=0))) / view.distance
        score = share_seen(view.position) + 0.5 * extent - 0.02 * rank
        if score > best_score:
            best, best_score = view, score
    assert best is not None
    return best


def visible_points(reduced: ReducedModel, motion: Floats) -> Floats:
    """Return corners of what must be in view: the robot during the motion, and the objects near it.

    Objects larger than the robot are cut to its surroundings; half-spaces do not count.

    Args:
        reduced: Robot and scene.
        motion: Positions of the group along the motion, shape (k, n) [rad | m].

    Returns:
        Shape (m, 3) in the world [m].
    """
    scene = reduced.scene
    shown = [b for b in (*scene.robot.bodies, *scene.object_bodies()) if not isinstance(b.shape, Plane)]
    moved: list[Floats] = []
    still: list[Floats] = []
    for positions in motion:
        place = reduced.all_positions(positions)
        frames = {body.frame: scene.placement_of(body.frame, place) for body in shown}
        moved.append(np.array([scene.placement_of(link, place).translation for link in scene.robot.links]))
        for body in shown:
            points = frames[body.frame] * (body.placement * _corners(*bounding_box(body.shape)))
            (still if body.frame == WORLD else moved).append(points)
    cloud = np.concatenate(moved)
    low, high = cloud.min(axis=0), cloud.max(axis=0)
    size = float(np.linalg.norm(high - low))
    near_low, near_high = low - SURROUNDINGS * size, high + SURROUNDINGS * size
    for points in still:
        lower, upper = points.min(axis=0), points.max(axis=0)
        if (lower > near_high).any() or (upper < near_low).any():
            continue
        if np.linalg.norm(upper - lower) > size:
            lower, upper = np.maximum(lower, near_low), np.minimum(upper, near_high)
        cloud = np.vstack((cloud, _corners(lower, upper)))
    return cloud


def _corners(lower: Floats, upper: Floats) -> Floats:
    """Corners of a box along the axes, shape (8, 3)."""
    choice = np.indices((2, 2, 2)).reshape(3, 8).T
    return np.where(choice, upper, lower)


def _axes(azimuth: float, elevation: float) -> Floats:
    """Directions forward, right and up of a camera, shape (3, 3), one a row."""
    forward = np.array(
        (
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        )
    )
    right = np.array((np.sin(azimuth), -np.cos(azimuth), 0.0))
    return np.stack((forward, right, np.cross(right, forward)))


def _project(offsets: Floats, axes: Floats) -> tuple[Floats, Floats]:
    """Depth (k,) and coordinates right and up (k, 2) of offsets from the target."""
    local = offsets @ axes.T
    return local[:, 0], local[:, 1:]
