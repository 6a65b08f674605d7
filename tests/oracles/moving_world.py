"""Random moving worlds, and how near things come in them: by Coal at samples, sharing nothing with the judge.

Where things are is evaluated here by SciPy, from the numbers that the tracks are made of.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf

import coal
import numpy as np
import pinocchio as pin
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, Slerp

import trajopt as to
from trajopt.geometry.geometry import collision_geometry
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Bools, Floats

FINE, FINEST = 1e-3, 1e-4
"""Time between samples, and where that leaves doubt [s]."""

Pose = tuple[Floats, Floats]
Poses = Callable[[Floats], Pose]
"""Rotations (k, 3, 3) and origins (k, 3) at times (k,)."""


@dataclass(frozen=True)
class Thing:
    """A thing in the scene, as it is made and where it is.

    Attributes:
        name: Its id.
        parts: Its shapes, placed in its frame.
        poses: Where its frame is.
        motion: The same, as the scene takes it; None where it rests.
        error: Radius, velocity and acceleration of what it may be off.
        appears: From then on it is there [s].
        expires: Until then [s].
    """

    name: str
    parts: tuple[tuple[to.Box | to.Sphere | to.Cylinder | to.Capsule, to.Placement], ...]
    poses: Poses
    motion: to.Track | None = None
    error: tuple[float, float, float] = (0.0, 0.0, 0.0)
    appears: float = -inf
    expires: float = inf

    def error_at(self, times: Floats) -> Floats:
        """Return how far it may be off at times [m]."""
        radius, velocity, acceleration = self.error
        return radius + velocity * times + acceleration * times**2 / 2.0

    def into(self, scene: to.Scene) -> to.Scene:
        """Return a scene with it."""
        times = {"appears": self.appears, "expires": self.expires}
        if self.motion is not None:
            return scene.add(self.name, self.parts, motion=to.Prediction(self.motion, self.error), **times)
        rotation, origin = self.poses(np.zeros(1))
        return scene.add(self.name, self.parts, to.Placement(rotation[0], origin[0]), **times)


def through(times: Floats, points: Floats, rotations: Rotation) -> tuple[to.Track, Poses]:
    """Return a track that is straight and turns evenly between times, and where it is."""
    places = [
        to.Placement(turned, point) for turned, point in zip(rotations.as_matrix(), points, strict=True)
    ]
    turning = Slerp(times, rotations)

    def poses(at: Floats) -> Pose:
        within = np.clip(at, times[0], times[-1])
        origin = np.stack([np.interp(within, times, column) for column in points.T], axis=1)
        return turning(within).as_matrix(), origin

    return to.Track.through(times, places), poses


def steady(
    start: float, end: float, point: Floats, rotation: Rotation, velocity: Floats, spin: Floats
) -> tuple[to.Track, Poses]:
    """Return a track of constant velocity, and where it is."""

    def poses(at: Floats) -> Pose:
        since = np.clip(at, start, end)[:, None] - start
        return (Rotation.from_rotvec(spin * since) * rotation).as_matrix(), point + velocity * since

    where = to.Placement(rotation.as_matrix(), point)
    return to.Track.constant_velocity(where, velocity, angular_velocity=spin, start=start, end=end), poses


def curved(times: Floats, points: Floats, rotation: Rotation, spins: Floats) -> tuple[to.Track, Poses]:
    """Return a track along a spline that spins at a rate of its own in each piece, and where it is."""
    spline, lengths = CubicSpline(times, points), np.diff(times)
    begins = [rotation]
    for spin, length in zip(spins, lengths, strict=True):
        begins.append(begins[-1] * Rotation.from_rotvec(spin * length))
    rates = np.linalg.norm(spins, axis=1)
    turned = np.array([begin.as_matrix() for begin in begins[:-1]])
    track = to.Track(times, np.ascontiguousarray(spline.c), turned, spins / rates[:, None], rates)

    def poses(at: Floats) -> Pose:
        within = np.clip(at, times[0], times[-1])
        piece = np.clip(np.searchsorted(times, within, side="right") - 1, 0, len(spins) - 1)
        begun = Rotation.concatenate([begins[number] for number in piece])
        since = Rotation.from_rotvec(spins[piece] * (within - times[piece])[:, None])
        return (begun * since).as_matrix(), spline(within)

    return track, poses


def carried(by: Thing, name: str, parts: Thing, offset: to.Placement) -> Thing:
    """Return a thing that rides on another, placed in its frame."""

    def poses(at: Floats) -> Pose:
        rotation, origin = by.poses(at)
        return rotation @ offset.rotation, origin + rotation @ offset.translation

    return replace(by, name=name, parts=parts.parts, poses=poses, appears=-inf, expires=inf)


@dataclass(frozen=True)
class Body:
    """A body that is carried: its shape, where it is at every sample, and a bound of the speed of its points.

    Attributes:
        shape: Its geometry.
        poses: Where it is at times.
        rotation: At the samples, shape (s, 3, 3).
        origin: At the samples, shape (s, 3) [m].
        speed: Largest speed of a point of it [m/s].
    """

    shape: coal.CollisionGeometry
    poses: Poses
    rotation: Floats
    origin: Floats
    speed: float

    @staticmethod
    def of(shape: coal.CollisionGeometry, poses: Poses, times: Floats) -> "Body":
        """Look where it is at all samples; from one to the next its speed changes by a tenth at most."""
        rotation, origin = poses(times)
        slide = np.linalg.norm(np.diff(origin, axis=0), axis=1)
        turn = np.linalg.norm(np.diff(rotation, axis=0), axis=(1, 2))  # of the matrices: at least the angle
        fastest = float((slide + _size(shape) * turn).max()) / float(times[1] - times[0])
        return Body(shape, poses, rotation, origin, 1.1 * fastest + 1e-3)


class Oracle:
    """How near the robot's bodies come to things, at samples of time.

    Attributes:
        samples: Distances that were measured.
    """

    def __init__(self, reduced: ReducedModel, motion: to.Trajectory, things: list[Thing]) -> None:
        """Look where everything is, a thousand times a second.

        Args:
            reduced: The robot in a scene in which nothing changes.
            motion: How it moves.
            things: What it may meet.
        """
        self.samples = 0
        self._reduced, self._motion, self._things = reduced, motion, things
        self._data = reduced.model.createData()
        self._request, self._result = coal.DistanceRequest(), coal.DistanceResult()
        self._times = np.append(np.arange(0.0, motion.duration, FINE), motion.duration)
        names = set(reduced.scene.robot.links)
        self._links = [body for body in reduced.bodies if body.owner in names]
        frames = self._frames(self._times)
        self._robot = [
            self._body(collision_geometry(link.shape), self._of_link(number, frames))
            for number, link in enumerate(self._links)
        ]
        self._parts = [
            [self._body(collision_geometry(shape), _placed(thing.poses, at)) for shape, at in thing.parts]
            for thing in things
        ]

    def first_below(self, level: float, *, moving: bool = False) -> tuple[float, str, str, float] | None:
        """Return the first sample at which something is nearer than a level, less its error; None for none.

        Args:
            level: The distance [m].
            moving: Whether to look at a link only while a joint that carries it moves.
        """
        for thing, parts in zip(self._things, self._parts, strict=True):
            for link, body in zip(self._links, self._robot, strict=True):
                if thing.motion is None and not self._carriers(link.joint):
                    continue  # nothing moves the two against each other
                looks = self._looks(thing, moves=self._moves(link.joint) if moving else None)
                for part in parts:
                    when = self._below(body, part, thing, level, looks)
                    if when is not None:
                        return when[0], link.owner, thing.name, when[1]
        return None

    def between(self, link: str, name: str, time: float) -> float:
        """Return the distance of a link from a thing at a time, less its error [m]."""
        ((thing, parts),) = (
            each for each in zip(self._things, self._parts, strict=True) if each[0].name == name
        )
        bodies = [body for body, fixed in zip(self._robot, self._links, strict=True) if fixed.owner == link]
        nearest = min(self._at(body, part, time) for body in bodies for part in parts)
        return nearest - float(thing.error_at(np.array(time)))

    def _below(
        self, body: Body, part: Body, thing: Thing, level: float, looks: Bools
    ) -> tuple[float, float] | None:
        grows = body.speed + part.speed + thing.error[1] + thing.error[2] * self._motion.duration
        sample, last = 0, len(self._times) - 1
        while sample <= last:
            time = float(self._times[sample])
            if not looks[sample]:
                sample += 1
                continue
            room = self._measured(body, part, sample) - float(thing.error_at(np.array(time))) - level
            if room < 0.0:
                return time, room + level
            if room < grows * FINE / 2.0 and sample < last and looks[sample + 1]:
                for between in np.arange(time + FINEST, self._times[sample + 1], FINEST).tolist():
                    room = self._at(body, part, between) - float(thing.error_at(np.array(between))) - level
                    if room < 0.0:
                        return between, room + level
            # What is farther than all can move until then is looked at later.
            sample += max(1, int(room / grows / FINE))
        return None

    def _looks(self, thing: Thing, moves: Bools | None) -> Bools:
        there = (self._times >= thing.appears) & (self._times <= thing.expires)
        return there if moves is None else there & moves

    def _moves(self, joint: int) -> Bools:
        """Say at which samples something that carries a joint moves, at them and around them."""
        around = self._times[:, None] + (-1e-5, 0.0, 1e-5)
        rates = self._motion(np.clip(around.ravel(), 0.0, self._motion.duration), 1).reshape(
            *around.shape, -1
        )
        moved = np.abs(rates) @ np.abs(self._reduced.mimic_matrix[self._carriers(joint)]).T
        return (moved > 1e-6).any(axis=2).all(axis=1)

    def _carriers(self, joint: int) -> list[int]:
        return [int(each) - 1 for each in self._reduced.model.supports[joint]][1:]

    def _body(self, shape: coal.CollisionGeometry, poses: Poses) -> Body:
        return Body.of(shape, poses, self._times[:-1] if len(self._times) > 2 else self._times)

    def _measured(self, one: Body, other: Body, sample: int) -> float:
        """Return the distance at a sample [m]; the end is none of the even ones."""
        if sample >= len(one.origin):
            return self._at(one, other, float(self._times[sample]))
        places = ((body.rotation[sample], body.origin[sample]) for body in (one, other))
        return self._distance(one, other, *places)

    def _at(self, one: Body, other: Body, time: float) -> float:
        places = (body.poses(np.array([time])) for body in (one, other))
        return self._distance(one, other, *((rotation[0], origin[0]) for rotation, origin in places))

    def _distance(self, one: Body, other: Body, first: Pose, second: Pose) -> float:
        self.samples += 1
        self._result.clear()
        places = coal.Transform3s(*first), coal.Transform3s(*second)
        return float(coal.distance(one.shape, places[0], other.shape, places[1], self._request, self._result))

    def _frames(self, times: Floats) -> Pose:
        """Return where all joints are at times, (k, joints, 3, 3) and (k, joints, 3)."""
        count = self._reduced.model.njoints
        rotation, origin = np.empty((len(times), count, 3, 3)), np.empty((len(times), count, 3))
        for number, positions in enumerate(self._motion(times)):
            pin.forwardKinematics(self._reduced.model, self._data, self._reduced.configuration(positions))
            for joint in range(count):
                place = self._data.oMi[joint]
                rotation[number, joint], origin[number, joint] = place.rotation, place.translation
        return rotation, origin

    def _of_link(self, number: int, frames: Pose) -> Poses:
        link = self._links[number]

        def poses(at: Floats) -> Pose:
            known = len(at) > 1  # all samples, or one time
            rotation, origin = frames if known else self._frames(at)
            turned, place = rotation[: len(at), link.joint], origin[: len(at), link.joint]
            return turned @ link.placement.rotation, place + turned @ link.placement.translation

        return poses


def _placed(poses: Poses, offset: to.Placement) -> Poses:
    def placed(at: Floats) -> Pose:
        rotation, origin = poses(at)
        return rotation @ offset.rotation, origin + rotation @ offset.translation

    return placed


def _size(shape: coal.CollisionGeometry) -> float:
    """Return the radius of a ball around a shape's origin that holds it [m]."""
    shape.computeLocalAABB()
    return float(shape.aabb_radius + np.linalg.norm(shape.aabb_center))
