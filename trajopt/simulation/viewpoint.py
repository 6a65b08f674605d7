"""From where a motion is seen best: chosen once, for pictures, films and the page in the browser.

A picture of a motion is good as far as it shows two kinds of curves: the paths of the tools, and the robot's
lines from joint to joint at moments of the motion. What something hides shows nothing, and what points at the
camera shows little. So a direction is as good as the length that these curves have in the picture, hidden
pieces left out. The lengths of the two kinds are multiplied: showing one well makes up for no loss of the
other.

Directions are a grid over the upper hemisphere, the camera as near as it can be with everything in view. What
is hidden is found by casting rays. Nothing is random: the same motion is always seen from the same place.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trajopt.robot.loading.mujoco_library import mujoco
from trajopt.scene.reduced import ReducedModel
from trajopt.simulation.camera import CameraView, frame_points, outermost, picture_coordinates, visible_points
from trajopt.simulation.picture_model import OBJECT_GROUP, PATH_POINTS, ROBOT_GROUP, PosedModel, tool_paths
from trajopt.simulation.sampled_motion import SampledMotion
from trajopt.values.arrays import Bools, Floats

AZIMUTHS = np.deg2rad(np.arange(0.0, 360.0, 15.0) + 140.0)
"""Directions that cameras look along, about z [rad]. From one to the next the width of a flat thing in view
changes by a quarter of its full width at most. The first, from the left front of a robot that looks along x,
wins ties."""
ELEVATIONS = np.deg2rad((-20.0, -35.0, -50.0))
"""Of these directions above the horizon [rad]: as a person sees a machine from some way off, from near by,
and over a wall. From higher still a picture is a plan, in which heights are lost."""
STEEPER = 0.1
"""A camera that looks down by one of these steps more must show this share more: people judge heights, and
what stands upright, better from the side."""
MOMENTS = 12
"""Moments at which the robot is looked at; each has an equal share of the pieces of the tools' lines."""
PIECES = 10
"""The robot's lines are looked at in pieces, this many to half the size of what is shown, or more."""
THICKNESS = 0.1
"""Of the robot, what is nearer to a piece than this share of its length does not hide it: that is the link
itself, the hand, or what it holds. Arms are several times longer than they are thick."""
HIDES = 0.1
"""An object that hides more than this share of either kind of curve is drawn translucent."""
AFTER_HIT = 1e-6
"""How far behind a surface the search goes on, as a share of the ray."""


@dataclass(frozen=True, eq=False)
class Viewpoint:
    """A camera, and what stands in its way.

    Attributes:
        camera: The camera.
        hiding: Objects between it and the motion, to be drawn translucent.
    """

    camera: CameraView
    hiding: frozenset[str]


@dataclass(frozen=True, eq=False)
class _Curves:
    """Pieces of what is looked at in one moment: first those of the tools' paths, then the robot's lines.

    Attributes:
        time: The moment [s].
        pieces: Both ends, shape (k, 2, 3) in the world [m].
        tools: How many of them are of the tools' paths.
    """

    time: float
    pieces: Floats
    tools: int

    @property
    def middles(self) -> Floats:
        """What rays are cast to, shape (k, 3) [m]."""
        return self.pieces.mean(axis=1)

    @property
    def lengths(self) -> Floats:
        """Shape (k,) [m]."""
        return np.linalg.norm(self.pieces[:, 1] - self.pieces[:, 0], axis=1)

    @property
    def of_tools(self) -> Bools:
        """Which are of the tools' paths, shape (k,)."""
        return np.arange(len(self.pieces)) < self.tools


def look_at(reduced: ReducedModel, motion: SampledMotion, aspect: float) -> Viewpoint:
    """Choose from where to look at a motion that is drawn by other means.

    Args:
        reduced: Robot and scene.
        motion: What is shown.
        aspect: Width of the picture over its height.
    """
    shown = in_view(reduced, motion)
    return best_viewpoint(PosedModel(reduced, motion, shown), shown, aspect)


def in_view(reduced: ReducedModel, motion: SampledMotion, highlight: Collection[str] = ()) -> Floats:
    """Return points around what must be in view: robot, tools' paths and what is highlighted, (k, 3) [m]."""
    times = np.linspace(0.0, motion.duration, MOMENTS)
    along = np.array([motion(t) for t in times])
    cloud = visible_points(reduced, along, times=times, always=highlight)
    return np.concatenate((cloud, tool_paths(reduced, motion).reshape(-1, 3)))


def best_viewpoint(posed: PosedModel, shown: Floats, aspect: float) -> Viewpoint:
    """Choose from where a motion is seen best.

    Args:
        posed: Robot and scene during the motion.
        shown: What must be in view, shape (k, 3) in the world [m].
        aspect: Width of the picture over its height.
    """
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
    """Find what stands between a camera and the motion."""
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
    """Put the model into one moment after the other, and yield what is looked at in it."""
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
    """Return the pieces of a line (2, 3), none longer than asked, shape (k, 2, 3)."""
    count = int(np.linalg.norm(line[1] - line[0]) / longest) + 1
    corners = line[0] + np.linspace(0.0, 1.0, count + 1)[:, None] * (line[1] - line[0])
    return np.stack((corners[:-1], corners[1:]), axis=1)


def _hidden(posed: PosedModel, camera: CameraView, curves: _Curves) -> Bools:
    """Tell which pieces are hidden, by objects or by another part of the robot."""
    eye, rays = camera.position, curves.middles - camera.position
    by_robot = _first_hits(posed, eye, rays, ROBOT_GROUP) < 1.0 - _near(curves) / np.linalg.norm(rays, axis=1)
    return by_robot | (_first_hits(posed, eye, rays, OBJECT_GROUP) < 1.0)


def _near(curves: _Curves) -> float:
    """Return how far from its middle a link may reach [m]."""
    return THICKNESS * float(curves.lengths[~curves.of_tools].sum())


def _first_hits(posed: PosedModel, eye: Floats, rays: Floats, group: int) -> Floats:
    """Return where rays meet geometries of a group first, as shares of the rays; inf where nowhere."""
    count = len(rays)
    geoms, shares = np.empty(count, np.int32), np.empty(count)
    mujoco.mj_multiRay(
        posed.model, posed.data, eye, rays.ravel(), _only(group), True, -1, geoms, shares, None, count, 1e10
    )
    return np.where(geoms < 0, np.inf, shares)


def _between(posed: PosedModel, eye: Floats, point: Floats) -> set[str]:
    """Return the objects between a camera and a point."""
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
