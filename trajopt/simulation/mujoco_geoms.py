"""Shapes as geometries of MuJoCo: each becomes a native one, or convex meshes."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trajopt.robot.loading.mujoco_library import mujoco
from trajopt.robot.mesh_cover import MeshPolicy, cover_mesh
from trajopt.values.arrays import Floats, Ints, readonly
from trajopt.values.placement import Placement
from trajopt.values.shapes.clouds.points import Points
from trajopt.values.shapes.clouds.surface import centres_of, fewer
from trajopt.values.shapes.clouds.voxels import Voxels
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Convex, Cylinder, Plane, Shape, Sphere, convex

CONE_TOLERANCE = 5e-6
"""Largest distance of the pyramid around a cone from it [m]."""
MOST_CONE_SIDES = 512
"""Largest number of sides of that pyramid; reached at a radius of 13 cm."""
MOST_OF_CLOUD = 5_000
"""Largest number of spheres or cubes of a cloud; MuJoCo checks each of them in every step."""
HALF_SPACE_EDGE = 40.0
"""Edge of the box that replaces a half-space on a moving body [m]."""


@dataclass(frozen=True, eq=False)
class MujocoGeom:
    """A geometry of MuJoCo.

    Attributes:
        kind: Geometry type of MuJoCo.
        size: Size parameters of MuJoCo, shape (3,) [m].
        placement: In the frame of the shape.
        vertices: Of a mesh, shape (n, 3) [m]; empty for native types.
        faces: Of a mesh, outward triangles, shape (m, 3); empty for native types.
    """

    kind: mujoco.mjtGeom
    size: Floats
    placement: Placement
    vertices: Floats
    faces: Ints


def mujoco_geoms(shape: Shape, *, moving: bool) -> tuple[tuple[MujocoGeom, ...], str]:
    """Return the geometries of a shape, and a note on the difference.

    Args:
        shape: The shape.
        moving: Whether a joint moves it; MuJoCo has fixed half-spaces only.

    Returns:
        The geometries, and a sentence, empty if they are exact.
    """
    match shape:
        case Plane():
            return _half_space(moving=moving)
        case Cone():
            return _pyramid(shape)
        case Convex():
            return (surface(shape.vertices, shape.faces),), ""
        case Points() | Voxels():
            return _cloud(shape)
        case Mesh():
            cover = cover_mesh(shape, MeshPolicy())
            hulls = (hull for hull in cover.shapes if isinstance(hull, Convex))
            parts = tuple(surface(hull.vertices, hull.faces) for hull in hulls)
            return parts, f"the exact mesh is simulated by a cover that contains it: {cover.note}"
        case _:
            return (_primitive(shape),), ""


def scalar_first(placement: Placement) -> Floats:
    """Return the quaternion (w, x, y, z) of a placement, in the order of MuJoCo, shape (4,)."""
    x, y, z, w = placement.quaternion
    return np.array((w, x, y, z))


def surface(vertices: Floats, faces: NDArray[np.integer]) -> MujocoGeom:
    """Return a mesh, which is drawn exactly; contacts use its convex hull."""
    return MujocoGeom(mujoco.mjtGeom.mjGEOM_MESH, np.zeros(3), Placement(), vertices, faces.astype(np.int64))


def _primitive(shape: Box | Sphere | Cylinder | Capsule) -> MujocoGeom:
    kinds = mujoco.mjtGeom
    match shape:
        case Box():
            return _native(kinds.mjGEOM_BOX, shape.x / 2, shape.y / 2, shape.z / 2)
        case Sphere():
            return _native(kinds.mjGEOM_SPHERE, shape.radius)
        case Cylinder():
            return _native(kinds.mjGEOM_CYLINDER, shape.radius, shape.length / 2)
        case Capsule():
            return _native(kinds.mjGEOM_CAPSULE, shape.radius, shape.length / 2)


def _native(kind: mujoco.mjtGeom, *size: float) -> MujocoGeom:
    padded = np.zeros(3)
    padded[: len(size)] = size
    return MujocoGeom(kind, readonly(padded), Placement(), np.empty((0, 3)), np.empty((0, 3), dtype=np.int64))


def _cloud(cloud: Points | Voxels) -> tuple[tuple[MujocoGeom, ...], str]:
    """Return the spheres or cubes of a cloud; for a large one fewer that contain them."""
    shown = fewer(cloud, MOST_OF_CLOUD)
    one = _primitive(Sphere(shown.radius) if isinstance(shown, Points) else Box(*(shown.size,) * 3))
    each = tuple(
        replace(one, placement=Placement(translation=readonly(at.copy()))) for at in centres_of(shown)
    )
    if shown is cloud:
        return each, ""
    return each, f"{cloud} is simulated as {shown}, which contains it"


def _half_space(*, moving: bool) -> tuple[tuple[MujocoGeom, ...], str]:
    if not moving:
        return (_native(mujoco.mjtGeom.mjGEOM_PLANE, 0.0, 0.0, 1.0),), ""
    half = HALF_SPACE_EDGE / 2
    box = _native(mujoco.mjtGeom.mjGEOM_BOX, half, half, half)
    below = Placement(translation=readonly(np.array((0.0, 0.0, -half))))
    moved = MujocoGeom(box.kind, box.size, below, box.vertices, box.faces)
    return (moved,), f"the moving half-space is simulated as a box with edges of {HALF_SPACE_EDGE:g} m"


def _pyramid(shape: Cone) -> tuple[tuple[MujocoGeom, ...], str]:
    least = np.pi * np.sqrt(shape.radius / (2.0 * CONE_TOLERANCE))
    sides = int(np.clip(np.ceil(least), 16, MOST_CONE_SIDES))
    outer = shape.radius / np.cos(np.pi / sides)
    angle = 2.0 * np.pi * np.arange(sides) / sides
    base = np.stack((outer * np.cos(angle), outer * np.sin(angle), np.full(sides, -shape.length / 2)), axis=1)
    points = np.vstack((base, (0.0, 0.0, shape.length / 2)))
    excess = outer - shape.radius
    hull = convex(points)
    note = f"the cone is simulated as a pyramid of {sides} sides, up to {excess:.1e} m larger"
    return (surface(hull.vertices, hull.faces),), note
