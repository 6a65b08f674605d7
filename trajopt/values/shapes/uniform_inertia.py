"""Inertia of shapes of uniform density."""

import numpy as np
import pinocchio as pin

from trajopt.values.arrays import Floats
from trajopt.values.errors import ShapeError
from trajopt.values.shapes import shapes
from trajopt.values.shapes.clouds import centres_of
from trajopt.values.shapes.mesh import Mesh

THINNEST = 1e-6
"""Assumed thickness of a flat mesh [m]."""


def uniform_inertia(shape: shapes.Shape) -> pin.Inertia:
    """Return mass, centre of mass and moments of a shape of density 1 kg/m^3, in the shape's frame.

    A mesh counts as its convex hull, or as its bounding box if it is flat; balls and cubes of a cloud count
    individually, also where they overlap; a half-space has no mass.
    """
    match shape:
        case shapes.Box():
            return pin.Inertia.FromBox(shape.x * shape.y * shape.z, shape.x, shape.y, shape.z)
        case shapes.Sphere():
            return pin.Inertia.FromSphere(4.0 / 3.0 * np.pi * shape.radius**3, shape.radius)
        case shapes.Cylinder():
            volume = np.pi * shape.radius**2 * shape.length
            return pin.Inertia.FromCylinder(volume, shape.radius, shape.length)
        case shapes.Capsule():
            volume = np.pi * shape.radius**2 * (shape.length + 4.0 / 3.0 * shape.radius)
            return pin.Inertia.FromCapsule(volume, shape.radius, shape.length)
        case shapes.Cone():
            return _cone(shape)
        case shapes.Plane():
            return pin.Inertia.Zero()
        case shapes.Convex():
            return _polyhedron(shape)
        case Mesh():
            return _hull(shape)
        case shapes.Points() | shapes.Voxels():
            return _cloud(shape)


def _cone(cone: shapes.Cone) -> pin.Inertia:
    """Its centre of mass is a quarter of its height above the base."""
    volume = np.pi * cone.radius**2 * cone.length / 3.0
    across = 3.0 / 20.0 * cone.radius**2 + 3.0 / 80.0 * cone.length**2
    moments = volume * np.diag((across, across, 3.0 / 10.0 * cone.radius**2))
    return pin.Inertia(volume, np.array((0.0, 0.0, -cone.length / 4.0)), moments)


def _polyhedron(solid: shapes.Convex) -> pin.Inertia:
    """Add up the tetrahedra between a vertex and each face.

    A tetrahedron with a corner at the origin and the others at a, b, c has six times the volume
    d = a . (b x c), the first moment d / 24 s with s = a + b + c, and the second
    d / 120 (a a' + b b' + c c' + s s') (Tonon, J. Math. Stat. 1, 2005).
    """
    origin = solid.vertices[0]
    corners = solid.vertices[solid.faces] - origin
    six = np.linalg.det(corners)
    total = corners.sum(axis=1)
    volume = six.sum() / 6.0
    centre = six @ total / 24.0 / volume
    each = np.einsum("f,fki,fkj->ij", six, corners, corners) + np.einsum("f,fi,fj->ij", six, total, total)
    return pin.Inertia(volume, origin + centre, _moments(each / 120.0 - volume * np.outer(centre, centre)))


def _hull(mesh: Mesh) -> pin.Inertia:
    try:
        return _polyhedron(shapes.convex(mesh.vertices))
    except ShapeError:  # it lies in a plane
        lower, upper = shapes.bounding_box(mesh)
        edges = np.maximum(upper - lower, THINNEST)
        box = pin.Inertia.FromBox(float(np.prod(edges)), *edges.tolist())
        return pin.Inertia(box.mass, (lower + upper) / 2.0, box.inertia)


def _cloud(cloud: shapes.Points | shapes.Voxels) -> pin.Inertia:
    one = uniform_inertia(
        shapes.Sphere(cloud.radius)
        if isinstance(cloud, shapes.Points)
        else shapes.Box(cloud.size, cloud.size, cloud.size)
    )
    centres = centres_of(cloud)
    centre = centres.mean(axis=0)
    away = centres - centre
    moments = len(centres) * one.inertia + one.mass * _moments(away.T @ away)
    return pin.Inertia(len(centres) * one.mass, centre, moments)


def _moments(second: Floats) -> Floats:
    """Return moments of inertia from second moments of the mass, both (3, 3) [kg m^2] about its centre."""
    return np.trace(second) * np.eye(3) - second
