"""Clouds, and the same balls and cubes as parts of their own."""

import numpy as np

import trajopt as to
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.shapes.shapes import Shape

REACH = 0.12


def ball_parts(cloud: to.Points | to.Voxels) -> list[tuple[Shape, to.Placement]]:
    if isinstance(cloud, to.Points):
        return [(to.Sphere(cloud.radius), to.placement(point)) for point in cloud.points]
    cube = to.Box(cloud.size, cloud.size, cloud.size)
    return [(cube, to.placement(centre)) for centre in cloud.centres]


def some_points(seed: int, count: int = 60, radius: float = 0.01) -> to.Points:
    random = np.random.default_rng(seed)
    middle = random.uniform((-0.8, -0.8, 0.0), (0.8, 0.8, 0.4), (4, 3))
    return to.Points(middle[random.integers(4, size=count)] + random.normal(0.0, 0.08, (count, 3)), radius)


def some_cells(seed: int, count: int = 60, size: float = 0.03) -> to.Voxels:
    return to.Voxels(np.floor(some_points(seed, count).points / size).astype(np.int64), size)


def carried(kind: str) -> Shape:
    """Return a shape that a robot may carry."""
    corners = np.random.default_rng(5).normal(0.0, 0.06, (20, 3))
    shapes: dict[str, Shape] = {
        "box": to.Box(0.1, 0.2, 0.06),
        "sphere": to.Sphere(0.07),
        "cylinder": to.Cylinder(0.05, 0.2),
        "capsule": to.Capsule(0.04, 0.2),
        "cone": to.Cone(0.06, 0.2),
        "hull": to.convex(corners),
        "points": to.Points(corners, 0.01),
        "cells": to.Voxels(np.floor(corners / 0.02).astype(np.int64), 0.02),
    }
    return shapes[kind]


CARRIED = ("box", "sphere", "cylinder", "capsule", "cone", "hull", "points", "cells")


def as_parts(shape: Shape) -> Shape | list[tuple[Shape, to.Placement]]:
    return ball_parts(shape) if isinstance(shape, to.Points | to.Voxels) else shape


def arm_beside(
    cloud: to.Points | to.Voxels, held: Shape, where: to.Placement, *, parts: bool
) -> ReducedModel:
    """Two rods that carry a shape beside a cloud, or beside its balls and cubes as parts."""
    scene = to.Scene(to.load("planar2"))
    link = scene.robot.links[-1]
    scene = scene.add("cloud", ball_parts(cloud) if parts else cloud, where)
    scene = scene.add("floor", to.Plane(), to.placement((0.0, 0.0, -0.4)))
    scene = scene.add(
        "held", as_parts(held) if parts else held, to.placement((0.05, 0.0, 0.1), rpy=(0.3, 0.2, 0.1)),
        frame=link, touch_links=scene.robot.links,
    )  # fmt: skip
    return reduce_model(scene, "arm", np.zeros(len(scene.robot.joint_names)))


def least(
    reduced: ReducedModel, samples: np.ndarray, pairs: np.ndarray, values: np.ndarray
) -> dict[object, float]:
    """Return the smallest value of each sample and two owners."""
    found: dict[object, float] = {}
    for sample, pair, value in zip(samples.tolist(), pairs.tolist(), values.tolist(), strict=True):
        key = (sample, *sorted(reduced.owners(pair)))
        found[key] = min(value, found.get(key, np.inf))
    return found
