"""What distances are measured to where a link or object is a mesh: the shapes that cover it."""

import logging
from dataclasses import dataclass, field
from enum import Enum
from itertools import pairwise
from pathlib import Path
from time import monotonic

import numpy as np

from trajopt.native import covers
from trajopt.values.array_cache import Arrays, cached_arrays
from trajopt.values.arrays import Floats, readonly
from trajopt.values.errors import ShapeError
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


THICKNESS = covers.THICKNESS
"""Least thickness of a piece [m]: to a flatter one as much is added, half on either side."""
FARTHEST = covers.FARTHEST
"""Tolerances by which pieces stand out of a mesh at most, where the work suffices that they may cost."""
VERSION = 4
"""Of the algorithm: part of the key of what is kept on disk."""

_SAMPLES = 40_000  # points in the hull of a mesh at which its distance is looked at
_MOST_WORK = 3 * 10**8  # points times planes that cutting may cost, half a second; merging as much again


class CoverMethod(Enum):
    """How a mesh became convex."""

    HULL = "hull"
    DECOMPOSITION = "decomposition"


@dataclass(frozen=True, eq=False)
class ConvexCover:
    """Convex pieces whose union contains the surface of a mesh.

    Attributes:
        pieces: Extreme points of each piece, frame of the mesh, shape (k, 3) [m], read-only.
        method: Whether the one piece is the mesh's hull, or the mesh was cut.
        excess: Volume that the plain hull adds, as a share of the mesh's (the union of its closed
            parts, with hollows that nothing can enter); infinite if the mesh bounds no volume, and
            None where nobody asked, as the hull is within the tolerance everywhere.
        reach: No piece stands out of the mesh farther than this [m]: an upper bound, found by dividing
            the pieces' faces until it is below the tolerance or as good as reached.
    """

    pieces: tuple[Floats, ...]
    method: CoverMethod
    excess: float | None
    reach: float

    def __post_init__(self) -> None:
        """Make the pieces read-only."""
        for piece in self.pieces:
            readonly(piece)


def convex_pieces(
    mesh: Mesh, *, hull_excess: float = 0.05, tolerance: float = 0.01, max_pieces: int = 64
) -> ConvexCover:
    """Cover the surface of a mesh by convex pieces.

    The mesh becomes its hull where that stands out of it no farther than `tolerance`, or adds at most
    `hull_excess` of volume and stands out no farther than twice the tolerance. Otherwise it is cut until
    no piece stands out farther than `tolerance`, a fifth more at most, at the points looked at in the
    hull, nor by half as much again anywhere between them, unless `max_pieces` do not suffice, or the work
    does not that cutting and merging may cost: it is counted (no clock is asked), and takes about a second
    of one processor. Then pieces stay that stand out farther. `reach` says by how much at most. So a
    distance to the pieces is the true one or smaller, by at most that. Pieces may fill what a ball of
    radius `tolerance` cannot enter from outside: narrow holes, shut hollows. An open mesh is a thin sheet,
    no solid.

    Covers are kept on disk, in the folder $TRAJOPT_CACHE_DIR or else the user's cache folder.

    Args:
        mesh: Closed or open, of one or many parts, which may overlap.
        hull_excess: Share of the mesh's volume that its hull may add.
        tolerance: Farthest that pieces may stand out of the mesh [m].
        max_pieces: Cutting ends at so many; merging leaves fewer.

    Returns:
        The pieces. They contain the surface whatever the options are.

    Raises:
        ShapeError: If the mesh has no face, or an option is out of range.
    """
    if not len(mesh.faces):
        raise ShapeError("mesh", "has no face, so there is nothing to cover")
    if not (hull_excess >= 0.0 and tolerance > 0.0 and max_pieces >= 1):
        given = f"{hull_excess:g}, {tolerance:g}, {max_pieces}"
        raise ShapeError("hull_excess, tolerance, max_pieces", f"need >= 0, > 0, >= 1, are {given}")
    options = np.array([VERSION, _SAMPLES, _MOST_WORK, THICKNESS, hull_excess, tolerance, max_pieces])
    key = (mesh.vertices.tobytes(), mesh.faces.tobytes(), options.tobytes())

    def make() -> Arrays:
        cover = _cover(mesh, hull_excess, tolerance, max_pieces)
        return {
            "points": np.concatenate(cover.pieces),
            "ends": np.cumsum([len(piece) for piece in cover.pieces]),
            "method": np.array(cover.method.value),
            "figures": np.array([np.nan if cover.excess is None else cover.excess, cover.reach]),
        }

    kept = cached_arrays("convex", key, ("points", "ends", "method", "figures"), make)
    excess, reach = kept["figures"].tolist()
    pieces = np.split(kept["points"], kept["ends"][:-1])
    known = None if np.isnan(excess) else excess
    return ConvexCover(tuple(pieces), CoverMethod(str(kept["method"])), known, reach)


def _cover(mesh: Mesh, hull_excess: float, tolerance: float, max_pieces: int) -> ConvexCover:
    part, closed = mesh.parts(tolerance)
    points, ends, cut, excess, reach = covers.cover(
        mesh.vertices,
        mesh.faces,
        np.where(closed[part], part, -1).astype(np.int32),
        hull_excess,
        tolerance,
        max_pieces,
        _SAMPLES,
        _MOST_WORK,
    )
    pieces = tuple(_extreme(piece) for piece in np.split(points, ends[:-1]))
    method = CoverMethod.DECOMPOSITION if cut else CoverMethod.HULL
    return ConvexCover(pieces, method, None if np.isnan(excess) else excess, reach)


def _extreme(points: Floats) -> Floats:
    """Return the extreme points of a hull's vertices, which may lie in its faces to within rounding."""
    from scipy.spatial import ConvexHull

    return points[ConvexHull(points).vertices]


FIRST = 1.0
"""What takes less long is not told [s]: nobody waits for it."""
_EVERY = 2.0  # between two lines [s]
_LOG = logging.getLogger("trajopt.robot")


@dataclass
class CoverProgress:
    """Says how many meshes are done, once covering them has taken a second of the clock, then every two.

    The lines go to the logger "trajopt.robot" as warnings, which Python shows on standard error where nobody
    has set up logging: they tell why a first load is slow, and that the next will not be.

    Attributes:
        total: How many meshes there are.
        done: How many are covered.
    """

    total: int
    done: int = 0
    _next: float = field(default_factory=lambda: monotonic() + FIRST)

    def step(self, link: str) -> None:
        """Count one mesh.

        Args:
            link: The link that has it.
        """
        self.done += 1
        if self.done < self.total and monotonic() >= self._next:
            self._next = monotonic() + _EVERY
            _LOG.warning(
                "covering collision meshes by convex pieces, kept for the next time: %d of %d done, last %s",
                self.done,
                self.total,
                link,
            )
