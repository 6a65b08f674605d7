"""Random worlds for the oracle: things on tracks of every kind near a robot that moves and waits."""

from dataclasses import replace
from itertools import combinations
from math import inf

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

import trajopt as to
from tests.oracles.moving_world import Poses, Thing, carried, curved, steady, through
from trajopt.robot.joints import JointLimits
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats


def bare(robot: to.Robot) -> to.Scene:
    """Return a scene in which the robot's links may touch each other."""
    scene = to.Scene(robot)
    for one, other in combinations(robot.links, 2):
        scene = scene.allow(one, other)
    return scene


def free_limits(limits: JointLimits) -> JointLimits:
    """Return limits that any of the random motions keeps, so that the verdict is that on clearance."""
    count = len(limits.joint_names)
    wide = np.full(count, inf)
    fast = {name: np.full(count, 1e9) for name in ("velocity", "acceleration", "jerk")}
    return replace(limits, lower=-wide, upper=wide, effort=wide, **fast)


def random_motion(reduced: ReducedModel, rng: np.random.Generator) -> to.Trajectory:
    """Return a motion from the start, of one to four pieces, some of which wait; at rest at both ends."""
    pieces, size = int(rng.integers(1, 5)), len(reduced.joint_names)
    points = [reduced.start_positions]
    for _ in range(pieces):
        points.append(points[-1] + rng.uniform(-0.9, 0.9, size) * (rng.random() < 0.75))
    times = np.concatenate(((0.0,), np.cumsum(rng.uniform(0.2, 0.9, pieces))))
    positions = np.array(points)
    if rng.random() < 0.1:
        return to.Trajectory(reduced.joint_names, times, positions)
    velocities = rng.uniform(-0.5, 0.5, positions.shape) * (rng.random() < 0.5)
    waits = np.flatnonzero((np.diff(positions, axis=0) == 0.0).all(axis=1))
    velocities[[0, -1, *waits, *(waits + 1)]] = 0.0
    still = np.zeros_like(velocities)
    return to.Trajectory(
        reduced.joint_names, times, positions, velocities, *((still,) * (rng.random() < 0.6))
    )


def random_things(reduced: ReducedModel, motion: to.Trajectory, rng: np.random.Generator) -> list[Thing]:
    """Return one to four things that come near the robot where it is at some time, or nearly."""
    things: list[Thing] = []
    for number in range(int(rng.integers(1, 4))):
        point = _near(reduced, motion, rng)
        things.append(_random_thing(f"thing {number}", point, motion.duration, rng, moves=number == 0))
    if rng.random() < 0.3:
        offset = to.Placement(Rotation.random(rng=rng).as_matrix(), rng.uniform(-0.2, 0.2, 3))
        rider = replace(things[0], parts=_random_parts(rng))
        things.append(carried(things[0], "rider", rider, offset))
    return things


def into(scene: to.Scene, things: list[Thing]) -> to.Scene:
    """Return a scene with things; the rider on what carries it."""
    for thing in things:
        if thing.name != "rider":
            scene = thing.into(scene)
            continue
        carrier = things[0].poses(np.zeros(1))
        mine = thing.poses(np.zeros(1))
        offset = to.Placement(carrier[0][0], carrier[1][0]).inverse() * to.Placement(mine[0][0], mine[1][0])
        scene = scene.add("rider", thing.parts, offset, frame=things[0].name)
    return scene


def _near(reduced: ReducedModel, motion: to.Trajectory, rng: np.random.Generator) -> Floats:
    """Return where to pass: beside one of the robot's bodies at one time of its motion."""
    data = reduced.model.createData()
    pin.forwardKinematics(
        reduced.model, data, reduced.configuration(motion(float(rng.uniform(0.0, motion.duration))))
    )
    bodies = [body for body in reduced.bodies if body.owner in reduced.scene.robot.links]
    body = bodies[int(rng.integers(len(bodies)))]
    away = rng.normal(size=3)
    away *= rng.uniform(0.1, 0.7) / np.linalg.norm(away)
    return np.asarray(data.oMi[body.joint].act(body.placement.translation) + away)


def _random_thing(
    name: str, point: Floats, duration: float, rng: np.random.Generator, *, moves: bool
) -> Thing:
    track, poses = _random_track(point, duration, int(rng.integers(1 if moves else 0, 4)), rng)
    appears, expires = -inf, inf
    if rng.random() < 0.25:
        appears = float(rng.uniform(0.0, 0.7) * duration)
    if rng.random() < 0.25:
        expires = float(rng.uniform(max(appears, 0.0) / duration + 0.05, 1.1) * duration)
    error = tuple((rng.uniform(0.0, (0.02, 0.05, 0.05), 3) * (rng.random() < 0.5)).tolist())
    parts = _random_parts(rng)
    if track is None:
        error = (0.0, 0.0, 0.0)
    return Thing(name, parts, poses, track, (error[0], error[1], error[2]), appears, expires)


def _random_parts(
    rng: np.random.Generator,
) -> tuple[tuple[to.Box | to.Sphere | to.Cylinder | to.Capsule, to.Placement], ...]:
    def shape() -> to.Box | to.Sphere | to.Cylinder | to.Capsule:
        a, b, c = rng.uniform(0.03, 0.25, 3).tolist()
        return (to.Box(a, b, c), to.Sphere(a / 2), to.Cylinder(a / 2, b), to.Capsule(a / 2, b))[
            int(rng.integers(4))
        ]

    first = (shape(), to.placement((0.0, 0.0, 0.0)))
    if rng.random() < 0.7:
        return (first,)
    beside = to.Placement(Rotation.random(rng=rng).as_matrix(), rng.uniform(-0.15, 0.15, 3))
    return (first, (shape(), beside))


def _random_track(
    point: Floats, duration: float, kind: int, rng: np.random.Generator
) -> tuple[to.Track | None, Poses]:
    """Return a track of a kind, none for 0, and where the thing is."""
    rotation = Rotation.random(rng=rng)
    if kind == 0:
        fixed = rotation.as_matrix()
        return None, lambda at: (np.tile(fixed, (len(at), 1, 1)), np.tile(point, (len(at), 1)))
    if kind == 1:
        start = float(rng.uniform(-0.2, 0.5) * duration)
        spin, velocity = rng.uniform(-3.0, 3.0, 3) * (rng.random() < 0.6), rng.uniform(-0.8, 0.8, 3)
        begins = point - velocity * rng.uniform(0.0, 0.6) * duration
        return steady(
            start, start + float(rng.uniform(0.2, 1.5)) * duration, begins, rotation, velocity, spin
        )
    count = int(rng.integers(3, 7))
    times = np.sort(rng.uniform(-0.2, 1.2, count)) * duration + np.arange(count) * 0.02
    points = point + rng.uniform(-0.5, 0.5, (count, 3))
    points[int(rng.integers(count))] = point
    if kind == 2:
        turned = (
            Rotation.concatenate([rotation] * count)
            if rng.random() < 0.4
            else Rotation.random(count, rng=rng)
        )
        return through(times, points, turned)
    return curved(times, points, rotation, rng.uniform(-2.0, 2.0, (count - 1, 3)))
