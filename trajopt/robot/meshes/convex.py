"""Convex pieces that contain the surface of a mesh, for exact collision distances.

A mesh whose hull reaches nowhere far from it is one hull. Any other is cut by planes, greedily, until
no piece's hull holds a point farther than a tolerance from the mesh; then pieces that stay good
together are merged. Triangles are clipped exactly at the planes, so every point of the surface lies in
the hull of its own piece by construction. How, and what else was tried: docs/decisions/convex-pieces.md.
"""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from trajopt.native import covers
from trajopt.values.array_cache import Arrays, cached_arrays
from trajopt.values.arrays import Floats, readonly
from trajopt.values.errors import ShapeError
from trajopt.values.shapes.mesh_file import Mesh

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
