"""The best viewpoint of a motion, for pictures, films and the page in the browser.

It has the largest product of the visible lengths, in the picture, of the tools' paths and of the lines from
joint to joint at several times. Viewing directions form a grid over the upper hemisphere, with the nearest
camera that has everything in view; ray casting finds hidden pieces.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trajopt.robot.loading.mujoco_library import mujoco
from trajopt.scene.reduced import ReducedModel
from trajopt.simulation.camera import CameraView, frame_points, picture_coordinates, visible_points
from trajopt.simulation.picture_model import OBJECT_GROUP, PATH_POINTS, ROBOT_GROUP, PosedModel, tool_paths
from trajopt.simulation.sampled_motion import SampledMotion
from trajopt.values.arrays import Bools, Floats
from trajopt.values.shapes.shapes import outermost

AZIMUTHS = np.deg2rad(np.arange(0.0, 360.0, 15.0) + 140.0)
"""Viewing directions about z [rad]: between neighbours the apparent width of a flat object changes by at most
a quarter.
"""
ELEVATIONS = np.deg2rad((-20.0, -35.0, -50.0))
"""Viewing directions above the horizon [rad]: of a person from a distance, from nearby, and over a wall."""
STEEPER = 0.1
"""Share by which a camera one elevation steeper must show more: heights are easier to judge from the side."""
MOMENTS = 12
"""Times at which the robot is rated; each has an equal share of the pieces of the tool paths."""
PIECES = 10
"""Fewest pieces of the robot's lines per half the size of the shown region."""
THICKNESS = 0.1
"""Parts of the robot closer to a piece than this share of the robot's length do not hide it."""
HIDES = 0.1
"""Share of a kind of curves above which an object that hides them is drawn translucent."""
AFTER_HIT = 1e-6
"""Distance behind a surface at which the ray goes on, as a share of the ray."""


@dataclass(frozen=True, eq=False)
class Viewpoint:
    """A camera, and the objects that hide the motion from it."""

    camera: CameraView
    hiding: frozenset[str]


@dataclass(frozen=True, eq=False)
class _Curves:
    """Pieces of the rated curves at a time: first the tool paths', then the robot's lines."""

    time: float
    pieces: Floats
    tools: int

    @property
    def middles(self) -> Floats:
        return self.pieces.mean(axis=1)

    @property
    def lengths(self) -> Floats:
        return np.linalg.norm(self.pieces[:, 1] - self.pieces[:, 0], axis=1)

    @property
    def of_tools(self) -> Bools:
        return np.arange(len(self.pieces)) < self.tools


def look_at(reduced: ReducedModel, motion: SampledMotion, aspect: float) -> Viewpoint:
    """Choose the viewpoint of a motion drawn by other means; aspect is width over height."""
    shown = in_view(reduced, motion)
    return best_viewpoint(PosedModel(reduced, motion, shown), shown, aspect)


def in_view(reduced: ReducedModel, motion: SampledMotion, highlight: Collection[str] = ()) -> Floats:
    times = np.linspace(0.0, motion.duration, MOMENTS)
    along = np.array([motion(t) for t in times])
    cloud = visible_points(reduced, along, times=times, always=highlight)
    return np.concatenate((cloud, tool_paths(reduced, motion).reshape(-1, 3)))


def best_viewpoint(posed: PosedModel, shown: Floats, aspect: float) -> Viewpoint:
    """Choose the best viewpoint that has points (k, 3) of the world in view [m]."""
    outer = outermost(shown)
    cameras = [
        frame_points(outer, float(azimuth), float(elevation), aspect)
        for elevation in ELEVATIONS
        for azimuth in AZIMUTHS
    ]
    seen, whole = np.zeros((len(cameras), 2)), np.zeros(2)
    for curves in _moments(posed):
        kinds = np.stack((curves.of_tools, ~curves.of_tools), axis=1)
        whole += curves.lengths @ kinds
        for count, camera in enumerate(cameras):
            ends = picture_coordinates(camera, curves.pieces.reshape(-1, 3)).reshape(-1, 2, 2)
            drawn = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
            seen[count] += (drawn * ~_hidden(posed, camera, curves)) @ kinds
    scores = np.prod(seen[:, whole > 0.0], axis=1)
    steepness = np.repeat(np.arange(len(ELEVATIONS)), len(AZIMUTHS))
    return seen_from(posed, cameras[int((scores * (1.0 - STEEPER * steepness)).argmax())])


def seen_from(posed: PosedModel, camera: CameraView) -> Viewpoint:
    """Return the viewpoint of a camera, with the objects that hide the motion."""
    hidden: dict[str, Floats] = {}
    whole = np.zeros(2)
    for curves in _moments(posed):
        for middle, length, tool in zip(curves.middles, curves.lengths, curves.of_tools, strict=True):
            kind = np.array((float(tool), float(not tool)))
            whole += length * kind
            for owner in _between(posed, camera.position, middle):
                hidden[owner] = hidden.get(owner, np.zeros(2)) + length * kind
    return Viewpoint(
        camera, frozenset(owner for owner, lost in hidden.items() if (lost > HIDES * whole).any())
    )


def _moments(posed: PosedModel) -> Iterator[_Curves]:
    step = posed.motion.duration / MOMENTS
    longest = posed.model.stat.extent / PIECES
    along = np.linspace(0.0, MOMENTS, PATH_POINTS)
    for count in range(MOMENTS):
        posed.pose((count + 0.5) * step)
        ends = (along >= count) & (along <= count + 1)
        tools = np.concatenate([np.stack((path[ends][:-1], path[ends][1:]), axis=1) for path in posed.paths])
        robot = [_divided(line, longest) for line in posed.skeleton()]
        yield _Curves((count + 0.5) * step, np.concatenate((tools, *robot)), len(tools))


def _divided(line: Floats, longest: float) -> Floats:
    count = int(np.linalg.norm(line[1] - line[0]) / longest) + 1
    corners = line[0] + np.linspace(0.0, 1.0, count + 1)[:, None] * (line[1] - line[0])
    return np.stack((corners[:-1], corners[1:]), axis=1)


def _hidden(posed: PosedModel, camera: CameraView, curves: _Curves) -> Bools:
    eye, rays = camera.position, curves.middles - camera.position
    by_robot = _first_hits(posed, eye, rays, ROBOT_GROUP) < 1.0 - _near(curves) / np.linalg.norm(rays, axis=1)
    return by_robot | (_first_hits(posed, eye, rays, OBJECT_GROUP) < 1.0)


def _near(curves: _Curves) -> float:
    return THICKNESS * float(curves.lengths[~curves.of_tools].sum())


def _first_hits(posed: PosedModel, eye: Floats, rays: Floats, group: int) -> Floats:
    count = len(rays)
    geoms, shares = np.empty(count, np.int32), np.empty(count)
    mujoco.mj_multiRay(
        posed.model, posed.data, eye, rays.ravel(), _only(group), True, -1, geoms, shares, None, count, 1e10
    )
    return np.where(geoms < 0, np.inf, shares)


def _between(posed: PosedModel, eye: Floats, point: Floats) -> set[str]:
    found: set[str] = set()
    geom, begin, ray = np.zeros(1, np.int32), 0.0, point - eye
    while True:
        share = mujoco.mj_ray(
            posed.model, posed.data, eye + begin * ray, ray, _only(OBJECT_GROUP), True, -1, geom
        )
        if share < 0.0 or begin + share >= 1.0:
            return found
        found.add(posed.owners[int(geom[0])])
        begin += share + AFTER_HIT


def _only(group: int) -> NDArray[np.uint8]:
    mask = np.zeros(6, np.uint8)
    mask[group] = 1
    return mask
