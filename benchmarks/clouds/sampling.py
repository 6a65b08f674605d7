"""Scenes of boxes, cylinders and balls as clouds: points drawn on their surfaces, as VAMP's benchmarks do."""

from dataclasses import dataclass
from math import sqrt

import numpy as np

import trajopt as to

EACH = 10_000
"""Points drawn on the surface of each shape."""
RADIUS = 0.0025
"""Of the balls about the points as they are drawn [m]."""
CELL = 0.005
"""Edge of the cells that the thinned cloud has one point of [m]."""
COVERING = RADIUS + CELL * sqrt(3.0)
"""Radius with which any one point of a cell covers all balls of the cell [m]."""
RAW, THIN = "as drawn", "thinned"


@dataclass(frozen=True)
class Clouds:
    """A scene as two clouds.

    Attributes:
        raw: The points as they are drawn, with the small radius.
        thin: One point of each cell, with the radius that covers all.
    """

    raw: to.Points
    thin: to.Points


def clouds_of(scene: to.Scene, seed: int = 0) -> Clouds:
    """Draw points on all objects of a scene."""
    random = np.random.default_rng(seed)
    points = np.concatenate(
        [body.placement * on_surface(body.shape, EACH, random) for body in scene.object_bodies()]
    )
    cells = np.floor(points / CELL).astype(np.int64)
    _, first = np.unique(cells, axis=0, return_index=True)
    return Clouds(to.Points(points, RADIUS), to.Points(points[np.sort(first)], COVERING))


def with_cloud(problem: to.Problem, cloud: to.Points) -> to.Problem:
    """Return a problem in which one cloud stands for all objects."""
    scene = problem.scene
    for name in tuple(scene.objects):
        scene = scene.remove(name)
    (goal,) = problem.goals
    return to.Problem(
        scene=scene.add("cloud", cloud), group=problem.group, start=problem.start_positions, goal=goal
    )


def on_surface(shape: object, count: int, random: np.random.Generator) -> np.ndarray:
    """Draw points evenly over a shape's surface, in its own frame, shape (count, 3) [m]."""
    match shape:
        case to.Box():
            return _on_box(np.array((shape.x, shape.y, shape.z)), count, random)
        case to.Cylinder():
            return _on_cylinder(shape.radius, shape.length, count, random)
        case to.Sphere():
            drawn = random.normal(size=(count, 3))
            return shape.radius * drawn / np.linalg.norm(drawn, axis=1, keepdims=True)
        case _:
            raise ValueError(f"{type(shape).__name__}: only boxes, cylinders and spheres are drawn")


def _on_box(size: np.ndarray, count: int, random: np.random.Generator) -> np.ndarray:
    areas = np.array((size[1] * size[2], size[0] * size[2], size[0] * size[1]))
    axis = random.choice(3, count, p=areas / areas.sum())
    points = random.uniform(-0.5, 0.5, (count, 3))
    points[np.arange(count), axis] = random.choice((-0.5, 0.5), count)
    return points * size


def _on_cylinder(radius: float, length: float, count: int, random: np.random.Generator) -> np.ndarray:
    side, cap = length, radius / 2.0  # areas over the circumference
    on_side = random.uniform(0.0, side + 2.0 * cap, count) < side
    angle = random.uniform(0.0, 2.0 * np.pi, count)
    within = np.where(on_side, radius, radius * np.sqrt(random.uniform(0.0, 1.0, count)))
    height = np.where(
        on_side, random.uniform(-length / 2, length / 2, count), random.choice((-0.5, 0.5), count) * length
    )
    return np.stack((within * np.cos(angle), within * np.sin(angle), height), axis=1)
