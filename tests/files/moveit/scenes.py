"""What several tests of scenes share."""

from collections.abc import Callable

import numpy as np

from trajopt import Placement
from trajopt.files.moveit import SceneFile

Read = Callable[[str], SceneFile]
"""Reads a scene from a text."""


def same(a: Placement, b: Placement) -> bool:
    return np.allclose(a.homogeneous, b.homogeneous, atol=1e-12)


def where(file: SceneFile, name: str) -> Placement:
    return file.scene.placement_of(name, file.positions)


def with_objects(objects: str) -> str:
    return f"world: {{collision_objects: [{objects}]}}"


SPHERE = "primitives: [{type: sphere, dimensions: [0.1]}]"
