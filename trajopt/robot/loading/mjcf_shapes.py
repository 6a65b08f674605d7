"""Shapes of a compiled MuJoCo model, and which of its bodies it lets collide."""

from collections.abc import Mapping
from itertools import combinations, product
from typing import Any

import numpy as np

from trajopt.values.arrays import Floats, readonly
from trajopt.values.errors import ModelError, shown
from trajopt.values.placement import Placement
from trajopt.values.rotations import from_quaternion
from trajopt.values.shapes.mesh_file import Mesh
from trajopt.values.shapes.shapes import Box, Capsule, Cylinder, Plane, Shape, Sphere, convex

_ROUND = (24, 13)
"""Meridians and parallels of the hull around an ellipsoid: its corners stand out by 2 % of the radii."""


def rotation_of(quaternion: Floats) -> Floats:
    """Return the matrix of MuJoCo's quaternion, whose first number is w."""
    w, x, y, z = (float(value) for value in quaternion)
    return from_quaternion(x, y, z, w)


def geom_placement(model: Any, geom: int) -> Placement:
    """Return where a geom is in its body's frame."""
    position = np.array(model.geom_pos[geom], dtype=float)
    return Placement(readonly(rotation_of(model.geom_quat[geom])), readonly(position))


def geom_shape(model: Any, geom: int, name: str) -> Shape:
    """Return the shape of a geom; of an ellipsoid a hull around it.

    Args:
        model: MuJoCo's model.
        geom: Its place among the geoms.
        name: Its name, for errors.

    Raises:
        ModelError: If it is of a type that no link can have.
    """
    x, y, z = (float(value) for value in model.geom_size[geom])
    match int(model.geom_type[geom]):  # numbers of MuJoCo's mjtGeom
        case 0:
            return Plane()
        case 2:
            return Sphere(x)
        case 3:
            return Capsule(x, 2.0 * y)
        case 4:
            return _around_ellipsoid(np.array((x, y, z)))
        case 5:
            return Cylinder(x, 2.0 * y)
        case 6:
            return Box(2.0 * x, 2.0 * y, 2.0 * z)
        case 7:
            return _mesh(model, int(model.geom_dataid[geom]))
        case _:
            reason = "is a height field or a signed distance field, which no link can have"
            raise ModelError(f"geom {shown(name)} {reason}; use a mesh or primitives")


def _mesh(model: Any, mesh: int) -> Mesh:
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    face, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    corners = np.array(model.mesh_vert[first : first + count], dtype=float)
    return Mesh(corners, np.array(model.mesh_face[face : face + faces], dtype=np.int32))


def _around_ellipsoid(radii: Floats) -> Shape:
    """Return the hull of points around an ellipsoid, far enough out that it lies within."""
    turns, heights = _ROUND
    around = np.linspace(0.0, 2.0 * np.pi, turns, endpoint=False)
    points = np.array(
        [
            (np.sin(down) * np.cos(turn), np.sin(down) * np.sin(turn), np.cos(down))
            for down in np.linspace(0.0, np.pi, heights)[1:-1]
            for turn in around
        ]
        + [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]
    )
    hull = convex(points)
    corners = hull.vertices[hull.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    nearest = float(np.einsum("ij,ij->i", normals, corners[:, 0]).min())
    return convex(points / nearest * radii)


def collides(model: Any, geom: int) -> bool:
    """Say whether a geom ever touches anything; others are only seen."""
    return bool(model.geom_contype[geom] or model.geom_conaffinity[geom])


def untouching(model: Any, owners: Mapping[int, str]) -> frozenset[frozenset[str]]:
    """Return the pairs of links that are not checked against each other.

    Those of which no two geoms have bits in common, those that `<exclude>` names, and a body and what it
    hangs on, unless that is the world. MuJoCo does check a body against a base that stands still; here, as
    for any robot, contact there is construction.

    Args:
        model: MuJoCo's model.
        owners: The link of each geom that collides.
    """
    bits: dict[str, set[tuple[int, int]]] = {}
    bodies: dict[str, int] = {}
    for geom, link in owners.items():
        bits.setdefault(link, set()).add((int(model.geom_contype[geom]), int(model.geom_conaffinity[geom])))
        bodies.setdefault(link, int(model.geom_bodyid[geom]))
    excluded = {frozenset((int(pair) >> 16, int(pair) & 0xFFFF)) for pair in model.exclude_signature}
    pairs = zip(model.pair_geom1, model.pair_geom2, strict=True)
    demanded = {frozenset(owners.get(int(geom), "") for geom in pair) for pair in pairs}
    found: set[frozenset[str]] = set()
    for one, other in combinations(bits, 2):
        pair, bodies_of = frozenset((one, other)), (bodies[one], bodies[other])
        if pair in demanded:
            continue
        apart = not any(_bits_meet(a, b) for a, b in product(bits[one], bits[other]))
        if apart or frozenset(bodies_of) in excluded or _hang_together(model, *bodies_of):
            found.add(pair)
    return frozenset(found)


def _bits_meet(a: tuple[int, int], b: tuple[int, int]) -> bool:
    """Say whether geoms touch, given the contype and conaffinity of both."""
    return bool(a[0] & b[1] or b[0] & a[1])


def _hang_together(model: Any, a: int, b: int) -> bool:
    """Say whether both move as one, or one hangs on the other, which is not the world itself."""
    welds = model.body_weldid
    if welds[a] == welds[b]:
        return True
    for one, other in ((a, b), (b, a)):
        above = int(model.body_parentid[int(welds[one])])
        if above and (above == other or (welds[above] and welds[above] == welds[other])):
            return True
    return False
