"""What distances are measured to where a link or object is a mesh: the shapes that cover it."""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from trajopt.robot.meshes.convex import FARTHEST, VERSION, CoverMethod, convex_pieces
from trajopt.values.array_cache import Arrays, cached_arrays
from trajopt.values.arrays import Floats
from trajopt.values.errors.arguments import checked
from trajopt.values.shapes.closed_surface import closed_surface
from trajopt.values.shapes.mesh_file import ALONE, Mesh, load_mesh
from trajopt.values.shapes.shapes import Convex, Shape, convex

_VERSION = 4  # of what is kept: part of the key of the cache
_KEPT = ("vertices", "faces", "ends", "note", "centre", "coarse")


@checked
@dataclass(frozen=True)
class MeshPolicy:
    """How a collision mesh becomes what distances are measured to.

    Attributes:
        exact: Keep the triangles themselves (slower, and without depth of penetration) in place
            of convex pieces that contain them. What a closed part of them encloses is in contact;
            hollows whose faces point into them are not solid, and open parts have no inside.
        hull_excess: A mesh becomes its convex hull where that adds at most this share of volume
            and stands out of the mesh nowhere by more than twice the tolerance.
        tolerance: A mesh is cut until its pieces stand out of it by no more than this [m], a fifth more at
            most, at thousands of points looked at, and by half as much again anywhere between them; where
            the work does not suffice that a cover may cost, the note says by how much they do.
    """

    exact: bool = False
    hull_excess: float = 0.05
    tolerance: float = 0.01


@dataclass(frozen=True, eq=False)
class Cover:
    """The shapes that stand for a mesh.

    Attributes:
        shapes: One convex hull, several convex pieces, or the mesh itself.
        note: What they are, in words.
        centre: Mean of the mesh's vertices, shape (3,) [m].
        coarse: Whether the shapes stand out farther than the policy asks, as the note says.
    """

    shapes: tuple[Shape, ...]
    note: str
    centre: Floats
    coarse: bool = False


def cover_mesh(mesh: Mesh, policy: MeshPolicy) -> Cover:
    """Return the shapes that stand for a mesh, and say which they are."""
    centre = mesh.vertices.mean(axis=0)
    if policy.exact:
        known = f"exact mesh of {len(mesh.faces)} triangles"
        doubt = closed_surface(mesh).note
        return Cover((mesh,), f"{known}; {doubt}" if doubt else known, centre)
    cover = convex_pieces(mesh, hull_excess=policy.hull_excess, tolerance=policy.tolerance)
    shapes = tuple(convex(piece) for piece in cover.pieces)
    if cover.method is CoverMethod.HULL:
        return Cover(shapes, "convex hull", centre)
    note = f"{len(shapes)} convex pieces"
    coarse = cover.reach > FARTHEST * policy.tolerance
    if coarse:
        far, asked = 1000.0 * cover.reach, 1000.0 * policy.tolerance
        note += (
            f", which stand out of it by up to {far:.0f} mm: cutting came to its bound before "
            f"{asked:g} mm; MeshPolicy(exact=True) keeps the triangles"
        )
    return Cover(shapes, note, centre, coarse)


def cover_file(path: Path, scale: tuple[float, float, float], policy: MeshPolicy) -> Cover:
    """Return the shapes that stand for a mesh file, from the cache folder if they were made before.

    Then neither is the file parsed again, nor any hull made.

    Args:
        path: The file.
        scale: Factors along x, y, z, as in a URDF.
        policy: How the mesh becomes convex.

    Raises:
        MeshFileError: If the file is missing or unreadable, or holds no triangle.
    """
    if policy.exact or path.suffix.lower() not in ALONE or not path.is_file():
        return cover_mesh(load_mesh(path, scale), policy)

    def make() -> Arrays:
        cover = cover_mesh(load_mesh(path, scale), policy)
        shapes = [shape for shape in cover.shapes if isinstance(shape, Convex)]
        return {
            "vertices": np.concatenate([shape.vertices for shape in shapes]),
            "faces": np.concatenate([shape.faces for shape in shapes]),
            "ends": np.cumsum([(len(shape.vertices), len(shape.faces)) for shape in shapes], axis=0),
            "note": np.array(cover.note),
            "centre": cover.centre,
            "coarse": np.array(cover.coarse),
        }

    options = np.array([VERSION, _VERSION, *scale, policy.hull_excess, policy.tolerance])
    key = (path.suffix.lower().encode(), options.tobytes(), path.read_bytes())
    kept = cached_arrays("cover", key, _KEPT, make)
    vertices, faces = kept["vertices"], kept["faces"]
    for array in (vertices, faces):
        array.flags.writeable = False
    shapes = tuple(
        Convex(vertices[a:b], faces[c:d])
        for (a, c), (b, d) in pairwise(np.concatenate([[(0, 0)], kept["ends"]]).tolist())
    )
    return Cover(shapes, str(kept["note"]), kept["centre"], bool(kept["coarse"]))
