"""The bodies of a reduced model with the boxes and spheres that bound them, as arrays."""

from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats, Ints
from trajopt.model.reduced import ReducedModel
from trajopt.model.shapes import bounding_box

PLANE_EXTENT = 1e3
"""Half the edge of the box that stands for a half-space [m]."""


@dataclass(frozen=True, eq=False)
class BoundingBoxes:
    """Bounding boxes of B bodies, and the spheres around those.

    Attributes:
        joint: Joint that carries each body; 0 is the world, shape (B,).
        rotation: Of each body's shape in the joint's frame, shape (B, 3, 3).
        translation: Of the shape's origin there, shape (B, 3) [m].
        centre: Of the box there, shape (B, 3) [m].
        half: Half the box's edges, along the shape's axes, shape (B, 3) [m].
        radius: Of the sphere around the box, shape (B,) [m].
    """

    joint: Ints
    rotation: Floats
    translation: Floats
    centre: Floats
    half: Floats
    radius: Floats

    @staticmethod
    def of(reduced: ReducedModel) -> "BoundingBoxes":
        """Bound the bodies of a reduced model."""
        bodies = reduced.bodies
        joint = np.array([body.joint for body in bodies], dtype=np.int64)
        rotation = np.array([body.placement.rotation for body in bodies]).reshape(-1, 3, 3)
        translation = np.array([body.placement.translation for body in bodies]).reshape(-1, 3)
        boxes = np.array([bounding_box(body.shape) for body in bodies]).reshape(-1, 2, 3)
        corners = np.clip(boxes, -PLANE_EXTENT, PLANE_EXTENT)
        half = (corners[:, 1] - corners[:, 0]) / 2
        centre = np.einsum("bij,bj->bi", rotation, corners.mean(axis=1)) + translation
        return BoundingBoxes(joint, rotation, translation, centre, half, np.linalg.norm(half, axis=1))
