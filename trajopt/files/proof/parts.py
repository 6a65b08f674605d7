"""Convex parts of bodies as a proof states them."""

from dataclasses import dataclass

import numpy as np

from trajopt.robot.joints import FixedBody
from trajopt.values.arrays import Floats
from trajopt.values.placement import Placement
from trajopt.values.shapes.shapes import (
    Box,
    Capsule,
    Cone,
    Convex,
    Cylinder,
    Mesh,
    Plane,
    Shape,
    Sphere,
    bounding_sphere,
)
from trajopt.verify.kernel.shapes import hull_of

Document = dict[str, object]


@dataclass(frozen=True, eq=False)
class ConvexPart:
    """A convex part: all points within a distance of the hull of some points and two discs, or a half-space.

    Attributes:
        vertices: Points of the hull, in the body's frame, shape (v, 3) [m].
        discs: Height along z and radius of each disc about the z axis, shape (d, 2) [m].
    """

    body: FixedBody
    vertices: Floats
    radius: float
    discs: Floats

    @property
    def is_half_space(self) -> bool:
        return isinstance(self.body.shape, Plane)

    @property
    def sphere(self) -> tuple[Floats, float]:
        if len(self.vertices):
            centre = (self.vertices.min(axis=0) + self.vertices.max(axis=0)) / 2.0
            radius = float(np.linalg.norm(self.vertices - centre, axis=1).max()) + self.radius
        else:
            centre, radius = bounding_sphere(self.body.shape)
        return self.body.placement * centre, radius

    def support(self, direction: Floats) -> Floats:
        local = direction @ self.body.placement.rotation
        base = direction @ self.body.placement.translation
        if self.is_half_space:
            return base
        if len(self.vertices):
            return base + (local @ self.vertices.T).max(axis=1) + self.radius * np.linalg.norm(local, axis=1)
        across = np.hypot(local[:, 0], local[:, 1])
        heights, radii = self.discs.T
        return base + (local[:, 2:] * heights + across[:, None] * radii).max(axis=1)

    def document(self) -> Document:
        return {
            "owner": self.body.owner,
            "place": placed(self.body.joint, self.body.placement),
            "shape": self._shape(),
        }

    def _shape(self) -> Document:
        if self.is_half_space:
            return {"kind": "half-space"}
        if len(self.vertices):
            return {"kind": "hull", "vertices": self.vertices.tolist(), "radius": self.radius}
        (low, bottom), (high, top) = self.discs.tolist()
        return {"kind": "frustum", "bottom": bottom, "top": top, "length": high - low}


def placed(joint: int, where: Placement) -> Document:
    x, y, z, w = where.quaternion.tolist()
    return {"joint": joint, "rotation": [w, x, y, z], "translation": where.translation.tolist()}


def convex_part(body: FixedBody) -> ConvexPart | None:
    found = _outline(body.shape)
    return None if found is None else ConvexPart(body, *found)


def _outline(shape: Shape) -> tuple[Floats, float, Floats] | None:
    nothing = np.zeros((0, 3))
    match shape:
        case Box(x=x, y=y, z=z):
            signs = np.array(np.meshgrid((-0.5, 0.5), (-0.5, 0.5), (-0.5, 0.5))).reshape(3, 8).T
            return signs * (x, y, z), 0.0, nothing
        case Sphere(radius=radius):
            return np.zeros((1, 3)), radius, nothing
        case Capsule(radius=radius, length=length):
            return np.array(((0.0, 0.0, -length / 2.0), (0.0, 0.0, length / 2.0))), radius, nothing
        case Cylinder(radius=radius, length=length):
            return nothing, 0.0, np.array(((-length / 2.0, radius), (length / 2.0, radius)))
        case Cone(radius=radius, length=length):
            return nothing, 0.0, np.array(((-length / 2.0, radius), (length / 2.0, 0.0)))
        case Convex(vertices=vertices):
            return vertices, 0.0, nothing
        case Mesh():
            return hull_of(shape).vertices, 0.0, nothing
        case Plane():
            return nothing, 0.0, nothing
        case _:
            return None
